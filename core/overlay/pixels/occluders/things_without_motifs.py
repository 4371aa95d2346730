"""Things of a pattern's ground without its motifs: a belt, the lining of a collar.

Every place on the ground of a pattern has a motif within some distance, which most texels of the cloth show. Where the
photo shows none within one that is clearly larger, as the cloth is stretched there, something else lies. From such a
core it reaches to where motifs are near, or to edges in the photo.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats
from core.overlay.filters.distances import distance
from core.overlay.filters.smoothing import gaussian
from core.overlay.mesh import around
from core.overlay.pixels.filling import parts_with, solid
from core.overlay.pixels.jacobian_validity import stretches
from core.overlay.pixels.occluders.graph_cut import MOST, cut_out
from core.overlay.registration.region import without_specks

USUAL = 75
"""Per cent of the texels whose places have a motif within the usual distance."""
WHOLE, LEAST_TEXELS = 0.7, 6
"""Area of a texel that counts, over the median one, and how many there have to be."""
CLEARLY = 1.75
"""Distance from what is no ground, over the usual one, in the core of a thing."""
FURTHER, BESIDE = (1.25, 1.6), 0.85
"""Distance from motifs, over that, from which a pixel speaks for a thing, and does so fully; and up to which it speaks
for the cloth."""
EVIDENCE = 0.1
"""How much one pixel counts at most."""
WIDE, AROUND = 1.4, 1.4
"""Radius of the discs that fit into the known part of a thing, over that distance, and how far beyond it reaches."""
STRETCH, NEAR = (1.0, 2.5), 2.0
"""Pixels to one of undeformed cloth that are believed, and width of the neighbourhood that tells them, over the side of
a texel."""
FEW = 1e-4
"""Share of a neighbourhood that tells them as much as is known without it."""
LEAST, MOST_SHARE = 0.5, 1 / 3
"""Area of its known part, in texels, and share of all cloth beyond which it is the pattern that is not known well."""
HOLE = 0.6
"""Area of a hole in a thing, in texels, that is filled: a highlight."""
FINGERS = 0.7
"""Radius of a disc that fits into a thing, over that distance."""
SMOOTH_PX = 1.0
"""Blur of the outline."""


def plain_things(photo: Floats, uv: Floats, basis: Floats, ground: Bools, motifs: Bools) -> Bools:
    """Return the pixels (H, W) of things of the colour of a pattern's `ground` (H, W) that have no motifs.

    `photo` is (H, W, 3), `uv` (H, W, 2), NaN outside the cloth, `basis` (2, 2) pixels of undeformed cloth a texel;
    `motifs` (H, W) is where photo and model show the rest of the pattern.
    """
    side, out = float(np.sqrt(abs(np.linalg.det(basis)))), np.zeros(ground.shape, bool)
    covered, wide = np.isfinite(uv[..., 0]), stretch(uv, basis, motifs, NEAR * side)
    # Beyond the picture's edge there may be motifs.
    deep = distance(np.pad(~ground, 1, constant_values=True))[1:-1, 1:-1]
    usual = usual_depth(deep / wide, uv, motifs) * wide
    known = parts_with(deep > CLEARLY * usual, distance(deep > WIDE * usual) < WIDE * usual)
    known = without_specks(known, round(LEAST * side**2))
    if not known.any():
        return out
    box = around(known, 2 + round((1 + AROUND) * float(usual.max())))
    whole = outline(photo[box], covered[box], ground[box], known[box], usual[box])
    whole = without_holes(whole, HOLE * side**2) & covered[box]
    # Between the motifs beside it the cloth's own ground goes on into the thing.
    out[box] = solid(whole | ~covered[box], FINGERS * float(np.median(usual[known]))) & whole
    if out.sum() > MOST_SHARE * covered.sum():
        out[:] = False
    return out


def usual_depth(deep: Floats, uv: Floats, motifs: Bools) -> float:
    """Return how far places in a texel are from motifs at most, in most texels that have one; inf if that is not told.

    `deep` (H, W) is that distance, `uv` (H, W, 2) NaN outside the cloth.
    """
    covered = np.isfinite(uv[..., 0])
    if not covered.any():
        return float("inf")
    cells = np.floor(uv[covered]).astype(np.int64)
    cells -= cells.min(0)
    _, number = np.unique(cells[:, 0] * (cells[:, 1].max() + 1) + cells[:, 1], return_inverse=True)
    area, marked = np.bincount(number), np.bincount(number, motifs[covered])
    deepest = np.zeros(len(area))
    np.maximum.at(deepest, number, deep[covered])
    some = deepest[(area > WHOLE * np.median(area)) & (marked > 0)]
    return float(np.percentile(some, USUAL)) if len(some) >= LEAST_TEXELS else float("inf")


def stretch(uv: Floats, basis: Floats, sure: Bools, sigma_px: float) -> Floats:
    """Return the pixels (H, W) to one of undeformed cloth in the direction of most, as where it is `sure` (H, W)."""
    _, least, _ = stretches(uv, basis)
    weight = sure.astype(np.float64)
    size = -np.log(np.clip(least, 1 / STRETCH[1], STRETCH[1])) * weight
    return np.clip(np.exp(gaussian(size, sigma_px) / (gaussian(weight, sigma_px) + FEW)), *STRETCH)


def outline(photo: Floats, covered: Bools, ground: Bools, known: Bools, usual: Floats) -> Bools:
    """Return the things (H, W) of the colour of the `ground` (H, W) around the parts that are `known` (H, W).

    `usual` (H, W) is how far the pattern's ground reaches from motifs.
    """
    low, high = FURTHER
    away = distance(covered & ~ground) / usual
    speaks = EVIDENCE * np.clip((away - low) / (high - low), 0, 1)
    against = np.where(ground, EVIDENCE * np.clip(1 - away / BESIDE, 0, 1), 1.0)
    speaks[known & (away > 1)] = MOST
    against[distance(known) > AROUND * usual] = MOST
    found = cut_out(photo, ground, np.where(covered, against, 0.0), np.where(covered, speaks, 0.0)) & covered
    found = np.asarray((gaussian(found.astype(np.float64), SMOOTH_PX) > 0.5) & covered, np.bool_)
    return parts_with(known, found)


def without_holes(mask: Bools, most_px: float) -> Bools:
    """Return a mask (H, W) with its holes of fewer pixels filled."""
    beside = np.pad(~mask, 1, constant_values=True).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(beside, connectivity=4)
    holes = stats[:, cv2.CC_STAT_AREA] < most_px
    holes[labels[0, 0]] = False
    return np.asarray(mask | holes[labels][1:-1, 1:-1], np.bool_)
