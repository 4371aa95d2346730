"""Things that lie on the cloth: a bow, a label, a button.

Those of a colour of the pattern are taken for a motif that lies elsewhere. A patch of one colour that is much larger
than any patch of that colour in the texture, and mostly where the model has another colour, is none, and neither is a
ground without motifs. A thing of a colour that is no shade of the pattern's may be as small as a button.
"""

from collections.abc import Iterator

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints
from core.overlay.filters.distances import distance
from core.overlay.palette import GROUPS, from_shades, palette
from core.overlay.pixels.occluders.things_of_other_colour import foreign_things
from core.overlay.pixels.occluders.things_without_motifs import plain_things
from core.overlay.pixels.visible_pattern import without_cloth
from core.overlay.texel import Texel
from core.overlay.tolerances import LEAST_LIGHT, RIM_PX, SHADES

NEARER = 0.5
"""Distance of the photo from another colour, over that from the model's, under which the model is wrong."""
LARGER, LEAST_SHARE = 3.0, 0.15
"""Least area of a thing over the largest patch of its colour in the texture, and over the texel."""
ELSEWHERE = 0.5
"""Share of a thing where the model is wrong."""
DOUBTED = 0.15
"""Share of what is around a thing where the model may be wrong: beyond, it is the model that lies elsewhere."""
ODD, UNUSUAL = 0.24, 4.0
"""Distance of a colour from all shades of the pattern's from which it is none of them, at a light of one and over the
usual error."""
LEAST_PX = 12
"""Pixels of the smallest thing."""


def find_occluders(
    photo: Floats, texture: Floats, layers: tuple[Floats, Floats], texel: Texel, basis: Floats, covered: Bools
) -> Bools:
    """Return the pixels (H, W) of things that lie on the cloth.

    `photo` and `texture`, which is T(uv), are (H, W, 3); `layers` are uv (H, W, 2), NaN where it is not `covered`
    (H, W), and ρ (H, W); `basis` (2, 2) is pixels of undeformed cloth a texel.
    """
    uv, rho = layers
    colours = patch_colours(texel, basis)
    light, side = rho[..., None], float(np.sqrt(abs(np.linalg.det(basis))))
    off = np.stack([from_shades(photo, light * colour, SHADES) for colour in colours])
    seen = off.argmin(0)
    drawn = np.linalg.norm(texture[..., None, :] - colours, axis=-1).argmin(-1)
    wrong = (seen != drawn) & (off.min(0) < NEARER * from_shades(photo, light * texture, SHADES))
    out, kernel = np.zeros(covered.shape, bool), np.ones((2 * RIM_PX + 1, 2 * RIM_PX + 1), np.uint8)
    patches = largest_patches(texel, colours, basis)
    for number, area in enumerate(patches):
        if np.isfinite(area):
            least = max(LARGER * area, LEAST_SHARE * side**2)
            for part in large_parts(covered & (seen == number), wrong, least):
                around = ring(part, RIM_PX, 2 * RIM_PX + round(0.2 * side)) & covered
                if around.any() and wrong[around].mean() < DOUBTED:
                    out |= part
    out = cv2.dilate(out.astype(np.uint8), cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))) > 0
    out |= odd_things(photo, texture, rho, texel, covered) | foreign_things(photo, rho, texel, basis, covered)
    # What lies beside those is told without them.
    rest = np.asarray(covered & ~out, np.bool_)
    for number, area in enumerate(patches):
        if np.isinf(area):
            ground = np.asarray(rest & (seen == number), np.bool_)
            motifs = np.asarray(rest & ~ground & (seen == drawn), np.bool_)
            out |= plain_things(photo, np.where(rest[..., None], uv, np.nan), basis, ground, motifs)
    closed = np.asarray((cv2.morphologyEx(out.astype(np.uint8), cv2.MORPH_CLOSE, kernel) > 0) & covered, np.bool_)
    return without_cloth(closed, photo, texture, covered, side / 2)


def odd_things(photo: Floats, texture: Floats, rho: Floats, texel: Texel, covered: Bools) -> Bools:
    """Return the pixels (H, W) of things of a colour that is no shade of the texel's."""
    if not covered.any():
        return covered
    light = np.maximum(rho, LEAST_LIGHT)[covered]
    seen, shades = photo[covered], rho[covered][:, None]
    # A small motif may have a colour that is none of the palette's.
    colours = [*palette(texel), texture[covered]]
    off = np.min([from_shades(seen, shades * colour, (0.0, SHADES[1])) for colour in colours], axis=0)
    usual = float(np.median(np.abs(seen - shades * texture[covered])))
    odd = np.zeros(covered.shape, bool)
    odd[covered] = off > max(ODD, UNUSUAL * usual) * light
    # A seam is thin, and so is the rim of a motif.
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
    whole = cv2.morphologyEx(odd.astype(np.uint8), cv2.MORPH_OPEN, kernel)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(whole, connectivity=4)
    large = (whole > 0) & (stats[:, cv2.CC_STAT_AREA] >= LEAST_PX)[labels]
    return np.asarray(cv2.dilate(large.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0, np.bool_)


def patch_colours(texel: Texel, basis: Floats) -> Floats:
    """Return those colours (k, 3) of a texel that have patches of their own, and are not the rims of others.

    There are two at least.
    """
    colours = np.asarray(palette(texel, GROUPS), np.float64)
    nearest = np.tile(nearest_of(colours, texel), (2, 2))
    sample_px = np.sqrt(abs(float(np.linalg.det(basis))) / (texel.shape[0] * texel.shape[1]))
    radii = [cv2.distanceTransform((nearest == k).astype(np.uint8), cv2.DIST_L2, 5).max() for k in range(len(colours))]
    large = np.array(radii) * sample_px > RIM_PX
    return np.asarray(colours[large] if large.sum() > 1 else palette(texel, 2), np.float64)


def largest_patches(texel: Texel, colours: Floats, basis: Floats) -> list[float]:
    """Return the area of the largest connected patch of each colour in the texture, pixels; inf for a ground."""
    nearest = np.tile(nearest_of(colours, texel), (3, 3))
    sample = abs(float(np.linalg.det(basis))) / (texel.shape[0] * texel.shape[1])
    return [sample * largest_patch(nearest == number, texel.shape) for number in range(len(colours))]


def nearest_of(colours: Floats, texel: Texel) -> Ints:
    """Return the number (h, w) of the colour (k, 3) that each sample of a texel is most like."""
    return np.asarray(np.linalg.norm(texel.pixels[..., None, :] - colours, axis=-1).argmin(-1), np.int64)


def largest_patch(mask: Bools, shape: tuple[int, int]) -> float:
    """Return the size of the largest connected part of a texture of 3 by 3 texels; inf if one goes on for ever."""
    _, _, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    long = (stats[1:, cv2.CC_STAT_HEIGHT] > 1.9 * shape[0]) | (stats[1:, cv2.CC_STAT_WIDTH] > 1.9 * shape[1])
    return np.inf if long.any() else float(stats[1:, cv2.CC_STAT_AREA].max(initial=0))


def large_parts(mask: Bools, wrong: Bools, least: float) -> Iterator[Bools]:
    """Yield the connected parts (H, W) of a mask larger than `least` pixels that are mostly `wrong`."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    share = np.bincount(labels.ravel(), wrong.ravel(), count) / np.maximum(stats[:, cv2.CC_STAT_AREA], 1)
    for number in range(1, count):
        if stats[number, cv2.CC_STAT_AREA] > least and share[number] > ELSEWHERE:
            yield np.asarray(labels == number, np.bool_)


def ring(part: Bools, inner_px: int, outer_px: int) -> Bools:
    """Return the pixels (H, W) between two distances from a part."""
    away = distance(part)
    return np.asarray((away > inner_px) & (away <= outer_px), np.bool_)
