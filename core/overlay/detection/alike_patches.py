"""Alike patches of a picture: each is matched with all others by normalised cross-correlation (block matching).

Keypoints of a crumpled tartan are where folds and thin lines are, and hardly alike; its patches are.
"""

import math
from collections.abc import Iterator

import cv2
import numpy as np

from core.arrays import Bools, Ints, Points, Singles
from core.overlay.detection.displacement_votes import Pairs
from core.overlay.detection.subpixel import refine_maxima
from core.overlay.filters.shrinking import shrunk

LONGEST_PX = 300
"""Longest side of the picture that is compared; larger ones are shrunk by a whole number."""
SIDE = 15
"""Pixels of it to the side of a patch,"""
EVERY = 3
"""and from one patch that is looked for to the next at least; it is looked for at every pixel."""
MOST_ASKED = 3000
"""Patches that are looked for at most: a garment that fills such a picture has fewer, a picture of nothing but cloth
three times as many, and the work is with their square."""
INSIDE = 0.97
"""Share of a patch that lies in the region at least: its border is ragged."""
ALIKE = 0.6
"""Least correlation of alike patches."""
MOST = 12
"""Places that count for a patch at most, the most alike ones: a fine pattern has hundreds."""
APART = 5
"""Side of a neighbourhood of which the most alike place counts."""
CONTRAST = 0.02
"""Least standard deviation of a patch: what is more even is grain."""
AT_ONCE = 256
"""Patches that are compared at once."""


def find_alike_patches(image: Singles, valid: Bools, least_px: float) -> Pairs:
    """Return the middles of alike patches of a flattened `image` (H, W, 3) in `valid`, `least_px` apart or more.

    They are not so far apart that the cloth could not show the vector between them twice. The second of each pair is a
    place of its own, between the pixels of the picture that is compared.
    """
    times = -(-max(valid.shape) // LONGEST_PX)
    small, inside = shrunk(image, times).astype(np.float32), shrunk(valid[..., None], times)[..., 0] > 0.5
    y, x, patches = normalised_patches(small, np.asarray(inside, np.bool_))
    every = max(EVERY, math.ceil(math.sqrt(len(y) / MOST_ASKED)))
    asked = np.flatnonzero((y % every == 0) & (x % every == 0))
    most_px = float(np.linalg.norm(np.ptp(np.nonzero(valid), axis=1))) / 2 if valid.any() else 0.0
    middles = np.stack([x, y], -1).astype(np.float64)
    first, second = [np.empty(0, np.int64)], [np.empty((0, 2))]
    for one, alike in correlate(patches, asked):
        places, found = find_peaks(alike, y, x, inside.shape)
        away = times * np.linalg.norm(found - middles[one], axis=1)
        kept = np.flatnonzero((away > least_px) & (away < most_px))
        kept = kept[np.argsort(-alike[places[kept]], kind="stable")[:MOST]]
        first.append(np.full(len(kept), one))
        second.append(found[kept])
    seconds = np.concatenate(second)
    points = times * (np.concatenate([middles, seconds]) + 0.5) - 0.5
    return Pairs(points, np.concatenate(first), len(middles) + np.arange(len(seconds)))


def normalised_patches(image: Singles, inside: Bools) -> tuple[Ints, Ints, Singles]:
    """Return rows and columns (n,) of the middles of the patches `inside`, and these (n, d), of mean 0 and length 1.

    The mean is each channel's. A patch without contrast is 0.
    """
    half, window = SIDE // 2, (SIDE, SIDE)
    covered = cv2.boxFilter(inside.astype(np.float32), -1, window, borderType=cv2.BORDER_CONSTANT) > INSIDE
    y, x = np.nonzero(covered)
    if not len(y):
        return y, x, np.empty((0, 3 * SIDE**2), np.float32)
    found = np.lib.stride_tricks.sliding_window_view(image, window, (0, 1))[y - half, x - half].reshape(len(y), 3, -1)
    found = (found - found.mean(-1, keepdims=True)).reshape(len(y), -1)
    length = np.linalg.norm(found, axis=1, keepdims=True)
    seen = length > CONTRAST * np.sqrt(found.shape[1])
    return y, x, np.where(seen, found / np.maximum(length, 1e-9), np.float32(0))


def correlate(patches: Singles, asked: Ints) -> Iterator[tuple[int, Singles]]:
    """Yield each of the patches (n, d) that are `asked` for, by its row, with its correlations (n,) with all."""
    for start in range(0, len(asked), AT_ONCE):
        rows = asked[start : start + AT_ONCE]
        yield from zip(rows.tolist(), patches[rows] @ patches.T, strict=True)


def find_peaks(alike: Singles, y: Ints, x: Ints, shape: tuple[int, ...]) -> tuple[Ints, Points]:
    """Return which places (n,) at rows `y` and columns `x` are more alike than all around, and alike at all.

    With them comes where (n, 2) between the pixels they are most alike.
    """
    plane = np.full(shape, np.nan, np.float32)
    plane[y, x] = alike
    highest = cv2.dilate(np.nan_to_num(plane), np.ones((APART, APART), np.uint8))[y, x]
    places = np.flatnonzero((alike > ALIKE) & (alike == highest))
    at = x[places], y[places]
    return places, np.stack(at, -1) + refine_maxima(plane, *at)
