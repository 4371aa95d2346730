"""Alike patches of a picture: each is matched with all others by normalised cross-correlation (block matching).

Keypoints of a crumpled tartan are where folds and thin lines are, and hardly alike; its patches are.
"""

import math
from collections.abc import Iterator

import cv2
import numpy as np

from core.arrays import Bools, Ints, Points, Singles
from core.overlay.detection.displacement_votes import Pairs
from core.overlay.detection.subpixel import find_vertices
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
    around = find_neighbours(y, x, inside.shape)
    first, second = [np.empty(0, np.int64)], [np.empty((0, 2))]
    for one, alike in correlate(patches, asked):
        places, between = find_peaks(alike, around)
        found = middles[places] + between
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


def find_neighbours(y: Ints, x: Ints, shape: tuple[int, ...]) -> Ints:
    """Return which places (n, APART, APART) lie around each of the n at rows `y` and columns `x`: -1 where none is."""
    half = APART // 2
    numbers = np.full((shape[0] + 2 * half, shape[1] + 2 * half), -1)
    numbers[y + half, x + half] = np.arange(len(y))
    return np.lib.stride_tricks.sliding_window_view(numbers, (APART, APART))[y, x]


def find_peaks(alike: Singles, around: Ints) -> tuple[Ints, Points]:
    """Return which places (n,) are more alike than all `around` (n, APART, APART), and alike at all.

    With them comes how far (n, 2) from there, between the pixels, they are most alike.
    """
    places = np.flatnonzero(alike > ALIKE)
    values = np.append(alike, np.float32(np.nan))[around[places]]
    highest = alike[places] == np.fmax.reduce(values, axis=(1, 2))
    inner = slice(APART // 2 - 1, APART // 2 + 2)
    return places[highest], find_vertices(values[highest][:, inner, inner].reshape(-1, 9))
