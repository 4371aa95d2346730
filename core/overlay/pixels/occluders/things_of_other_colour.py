"""Large things of a colour near the pattern's own: a belt of the plaid's yellow, floor of the dots' grey.

A pixel's colour misses the shades of the pattern's by a little, by chance or alike wherever that colour of the pattern
is seen. Over a thing it misses them in one direction throughout, by more than is usual on the cloth. Single pixels tell
little; all together, with the edges in the photo, they tell the outline.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats
from core.overlay.filters.smoothing import gaussian
from core.overlay.mesh import around
from core.overlay.palette import palette
from core.overlay.pixels.filling import solid
from core.overlay.pixels.occluders.graph_cut import cut_out
from core.overlay.texel import Texel
from core.overlay.tolerances import LEAST_LIGHT, MOTIF, MOTIF_PX, SHADES, SMOOTH_PX

COLOURS = 8
"""Colours that stand for those of the pattern."""
UNUSUAL, LEAST = 5.0, 0.06
"""Length of what a thing misses by, over the usual one on the cloth, and at a light of one at least."""
WEAK, SURE = 0.5, 0.25
"""Share of that length that all of a thing has, and share of a thing that has all of it."""
TEXELS, SHARE = 0.4, 0.005
"""Least area of a thing, in texels and over that of the cloth."""
FURTHER, ALIKE = 0.2, 0.9
"""Least area, in texels, of a further part of a thing that misses in the same direction, and the cosine to it."""
HALF, EVIDENCE = 0.4, 0.5
"""Share of what a thing misses by from which a pixel speaks for it, and how much one counts at most."""
MARGIN = 1.5
"""Sides of a texel around its parts that a thing may reach."""


def foreign_things(photo: Floats, rho: Floats, texel: Texel, basis: Floats, covered: Bools) -> Bools:
    """Return the `covered` pixels (H, W) of large things of a colour near the pattern's.

    `photo` is (H, W, 3), `rho` (H, W); `basis` (2, 2) is pixels of undeformed cloth a texel.
    """
    out = np.zeros(covered.shape, bool)
    if not covered.any():
        return out
    side = float(np.sqrt(abs(np.linalg.det(basis))))
    missed, sigma = misses(photo, rho, texel, covered), max(MOTIF_PX, MOTIF * side)
    mass = np.maximum(gaussian(covered.astype(np.float64), sigma), 1e-3)[..., None]
    size = np.where(covered, np.linalg.norm(gaussian(missed, sigma) / mass, axis=-1), 0.0)
    limit = max(UNUSUAL * float(np.median(size[covered])), LEAST)
    weak = solid(np.asarray(size > WEAK * limit, np.bool_), max(MOTIF_PX, MOTIF * side))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(weak.astype(np.uint8), connectivity=4)
    area = stats[:, cv2.CC_STAT_AREA]
    sure = np.bincount(labels.ravel(), (size > limit).ravel(), count) > SURE * area
    sums = [np.bincount(labels.ravel(), plane.ravel(), count) for plane in np.moveaxis(missed, -1, 0)]
    means = np.stack(sums, -1) / area[:, None]
    turns = means / np.maximum(np.linalg.norm(means, axis=1, keepdims=True), 1e-9)
    least = max(TEXELS * side**2, SHARE * float(covered.sum()))
    left = np.arange(count) > 0
    for label in sorted(np.flatnonzero(left & sure & (area > least)), key=lambda label: -area[label]):
        if left[label]:
            same = left & (area > FURTHER * side**2) & (turns @ turns[label] > ALIKE)
            left &= ~same
            box = around(np.asarray(same[labels], np.bool_), round(MARGIN * side))
            part = np.asarray(same[labels[box]], np.bool_)
            out[box] |= outline(photo[box], part, missed[box], means[label], covered[box])
    return out & covered


def misses(photo: Floats, rho: Floats, texel: Texel, covered: Bools) -> Floats:
    """Return by what (H, W, 3), at a light of one, colours miss the nearest shade, over what they usually do there."""
    light, seen = rho[covered][:, None], photo[covered]
    colours = palette(texel, COLOURS).astype(np.float64)
    # How much of each colour is in a pixel (n, k), and the square of what that misses, but for the pixel's own.
    along, squares = seen @ colours.T, (colours**2).sum(1)
    amount = light * np.clip(light * along / np.maximum(light**2 * squares, 1e-9), *(0.0, SHADES[1]))
    nearest = np.argmin(amount * (amount * squares - 2 * along), axis=1)
    shade = np.take_along_axis(amount, nearest[:, None], axis=1) * colours[nearest]
    rest = (seen - shade) / np.maximum(light, LEAST_LIGHT)
    for number in np.unique(nearest):
        rest[nearest == number] -= np.median(rest[nearest == number], axis=0)
    out = np.zeros(photo.shape)
    out[covered] = rest
    return out


def outline(photo: Floats, part: Bools, missed: Floats, usual: Floats, covered: Bools) -> Bools:
    """Return a thing (H, W) that misses the shades by what is `usual` (3,), of which a `part` (H, W) is known."""
    like = missed @ usual / max(float(usual @ usual), 1e-9)
    speaks = np.where(covered, EVIDENCE * np.clip((like - HALF) / (1 - HALF), -1, 1), 0.0)
    found = cut_out(photo, covered, np.maximum(-speaks, 0), np.maximum(speaks, 0)) & covered
    found = np.asarray(gaussian(found.astype(np.float64), SMOOTH_PX) > 0.5, np.bool_)
    _, labels = cv2.connectedComponents(found.astype(np.uint8), connectivity=8)
    return np.asarray(found & np.isin(labels, np.unique(labels[part & found])), np.bool_)
