"""What lies on the cloth or before it, by one random field: a belt, a bow, a button, the lining of a collar.

Three terms say how much likelier a pixel shows a thing than the cloth that the model draws there, as logarithms:

- the texture, in whatever light, explains a neighbourhood no better than one colour does;
- the photo misses the shades of all the pattern's colours by more than is usual on this cloth;
- its patches of one colour are larger than is usual where the model has that colour.

A thing hides the pattern, and one of the other two holds. Things are the pixels for which all terms together, less what
the outline costs where the photo has no edge, are most (Boykov and Jolly 2001).
"""

from typing import TypeAlias

import cv2
import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filters.distances import distance
from core.overlay.filters.smoothing import mean
from core.overlay.palette import GROUPS, MANY, from_shades, palette
from core.overlay.pixels.graph_cut import EVIDENCE, SURELY, cut_out
from core.overlay.texel import Texel
from core.overlay.tolerances import LEAST_LIGHT, LEAST_NOISE, MOTIF, MOTIF_PX, RIM_PX, SHADES

Planes: TypeAlias = Floats | Singles

WINDOW = 0.15
"""Width of the neighbourhood that shows the pattern or does not, over the side of a texel."""
MISSED, LARGER, PRIOR = 0.7, 2.5, 4.25
"""How much speaks for a thing for each time that shades are missed, or patches large, as is usual, and for cloth before
that."""
LIKELY = 1.75
"""What a hidden pattern says at most, which may lie elsewhere."""
USUAL, STEP = (0.8, 0.95), 1.2
"""Share of a colour in patches whose radius is usual, and area; and the ratio of radii that are told apart."""


def find_occluders(photo: Planes, texture: Planes, rho: Planes, texel: Texel, side_px: float, covered: Bools) -> Bools:
    """Return the `covered` pixels (H, W) of things that lie on the cloth.

    `photo` and `texture`, which is T(uv), are (H, W, 3), `rho` is ρ (H, W), `side_px` the side of a texel.
    """
    if not covered.any():
        return covered
    missed = missed_shades(photo, texture, rho, texel, covered, max(MOTIF_PX, MOTIF * side_px))
    large = patch_sizes(photo, texture, rho, patch_colours(texel, side_px), covered)
    hidden = hidden_pattern(photo, texture, covered, WINDOW * side_px)
    thing = np.logaddexp(np.minimum(MISSED * missed, SURELY), LARGER * large) + np.minimum(hidden, LIKELY) - PRIOR
    return cut_out(photo, covered, np.where(covered, EVIDENCE * thing, 0.0)) & covered


def hidden_pattern(photo: Planes, texture: Planes, covered: Bools, sigma_px: float) -> Floats:
    """Return how much likelier (H, W), as a logarithm, a neighbourhood has one colour than the texture's.

    `photo` and `texture`, which is T(uv), are (H, W, 3). The colour, and the light of each channel, are those that suit
    the `covered` pixels (H, W) within `sigma_px` best.
    """
    seen, pattern, inside = (plane.astype(np.float32) for plane in (photo, texture, covered[..., None]))
    both, own = (mean(pattern * other, inside, sigma_px) for other in (seen, pattern))
    lit = np.asarray(both / np.maximum(own, np.float32(LEAST_NOISE**2)) * pattern, np.float32)
    models = lit, mean(seen, inside, sigma_px)
    drawn, even = (mean((seen - model) ** 2, inside, sigma_px).mean(-1) + LEAST_NOISE**2 for model in models)
    return np.asarray(photo.shape[-1] / 2 * np.log(drawn / even), np.float64)


def missed_shades(photo: Planes, texture: Planes, rho: Planes, texel: Texel, covered: Bools, sigma_px: float) -> Floats:
    """Return by what (H, W) colours miss the nearest shade throughout a neighbourhood, over what is usual.

    Shades are those of the pattern's colours and of the texture's T(uv) (H, W, 3) there. By what all misses that is
    nearest to one colour does not count.
    """
    light, seen, drawn = rho[covered][:, None], photo[covered], texture[covered]
    colours = palette(texel, MANY).astype(np.float64)
    along = np.concatenate([seen @ colours.T, (seen * drawn).sum(1, keepdims=True)], axis=1)
    of_colours = np.broadcast_to((colours**2).sum(1), (len(seen), len(colours)))
    squares = np.concatenate([of_colours, (drawn**2).sum(1, keepdims=True)], axis=1)
    amount = np.clip(along / np.maximum(squares, 1e-9), 0, SHADES[1] * light)
    nearest = np.argmin(amount * (amount * squares - 2 * along), axis=1)[:, None]
    colour = np.where(nearest == len(colours), drawn, colours[np.minimum(nearest[:, 0], len(colours) - 1)])
    rest = (seen - np.take_along_axis(amount, nearest, axis=1) * colour) / np.maximum(light, LEAST_LIGHT)
    for number in np.unique(nearest):
        here = nearest[:, 0] == number
        rest[here] -= np.median(rest[here], axis=0)
    out = np.zeros(photo.shape, np.float32)
    out[covered] = rest
    size = np.linalg.norm(mean(out, covered[..., None].astype(np.float32), sigma_px), axis=-1)
    return np.asarray(size / max(float(np.median(size[covered])), LEAST_NOISE), np.float64)


def patch_sizes(photo: Planes, texture: Planes, rho: Planes, colours: Floats, covered: Bools) -> Floats:
    """Return the size (H, W) of the patch of one of the `colours` (k, 3) that each pixel is in, over the usual one.

    A size is the radius of the largest disc around the pixel in its patch, or the side of a square as large as the
    patch; usual is what has the colour in the texture T(uv) (H, W, 3) too. It is 1 where neither is larger.
    """
    seen = np.stack([from_shades(photo, rho[..., None] * colour, SHADES) for colour in colours]).argmin(0)
    drawn = np.linalg.norm(texture[..., None, :] - colours, axis=-1).argmin(-1)
    out = np.ones(covered.shape)
    for number in np.unique(seen[covered & (seen == drawn)]):
        patch = covered & (seen == number)
        for size, usual in zip((disc_radii(patch), part_sides(patch)), USUAL, strict=True):
            out[patch] = np.maximum(out[patch], size[patch] / np.quantile(size[patch & (drawn == number)], usual))
    return out


def disc_radii(mask: Bools) -> Floats:
    """Return the radius (H, W) of the largest disc in a mask (H, W) that holds each pixel, `RIM_PX` at least."""
    # Beyond the picture's edge there may be something else.
    depth = distance(np.pad(~mask, 1, constant_values=True))[1:-1, 1:-1]
    radius, out = float(RIM_PX), np.full(mask.shape, float(RIM_PX))
    while radius <= depth.max():
        out[mask & (distance(depth >= radius) < radius)] = radius
        radius *= STEP
    return out


def part_sides(mask: Bools) -> Floats:
    """Return the side (H, W) of a square as large as the connected part of a mask (H, W) that each pixel is in."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    return np.asarray(np.sqrt(stats[:, cv2.CC_STAT_AREA])[labels], np.float64)


def patch_colours(texel: Texel, side_px: float) -> Floats:
    """Return those colours (k, 3) of a texel that have patches of their own, and are not the rims of others.

    There are two at least.
    """
    colours = np.asarray(palette(texel, GROUPS), np.float64)
    nearest = np.linalg.norm(texel.tiled(2, 2)[..., None, :] - colours, axis=-1).argmin(-1)
    radii = np.array([float(distance(nearest != number).max()) for number in range(len(colours))])
    large = radii * side_px > RIM_PX * np.sqrt(texel.shape[0] * texel.shape[1])
    return np.asarray(colours[large] if large.sum() > 1 else palette(texel, 2), np.float64)
