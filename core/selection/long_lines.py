"""Straight lines of a picture, and the long ones of all of it or of a part: horizons, walls, masts.

By the line segment detector (R. Grompone von Gioi, J. Jakubowicz, J.-M. Morel and G. Randall, "LSD: a line segment
detector", 2012), at a size at which what is small does not break them.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats, Points
from core.imaging.image import Image
from core.imaging.proxy import proxy, scale_for
from core.selection.collinear import join_collinear

LOOKED_PX = 320_000
"""Pictures are looked at with about so many pixels."""
_LONG, _BORDER = 0.1, 0.01
"""Shares of the picture's diagonal: what is long, and how near to a side of the frame a line is the frame's."""
_OFF_TEXELS = 1.0
"""Pixels of the picture as it is looked at by which ends that are found are off: pieces of a line lie so near to it."""
_BESIDE = _SHORTEST = 0.02
"""Such shares, too: a line that ends so near to the frame goes on to it, and none in a feature is shorter."""


def find_lines(image: Image) -> Points:
    """Return the ends (n, 2, 2) of the straight lines of a picture, in its pixels, the longest first."""
    looked = proxy(image, scale_for(image, LOOKED_PX))
    found = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD).detect(cv2.cvtColor(looked, cv2.COLOR_RGB2GRAY))[0]
    if found is None:
        return np.empty((0, 2, 2))
    size = np.array(image.size_px, np.float64)
    lines = (np.reshape(found, (-1, 2, 2)) + 0.5) * (size / looked.shape[1::-1]) - 0.5
    texel = float(np.max(size / looked.shape[1::-1]))
    lines = join_collinear(lines, _OFF_TEXELS * texel, _SHORTEST * float(np.hypot(*size)))
    lines = _reaching_the_frame(lines, size)
    border = _BORDER * float(np.hypot(*size))
    beside = np.all(lines < border, axis=1) | np.all(lines > size - 1 - border, axis=1)
    lines = np.clip(lines[~np.any(beside, axis=1)], -0.5, size - 0.5)
    return np.asarray(lines[np.argsort(-lengths_of(lines), kind="stable")])


def lengths_of(lines: Points) -> Floats:
    """Return the lengths (n,) of lines (n, 2, 2)."""
    return np.asarray(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1))


def are_long(lines: Points, size_px: tuple[int, int]) -> Bools:
    """Return which (n,) of the lines (n, 2, 2) are long in a picture of that size: horizons, walls."""
    return lengths_of(lines) > _LONG * float(np.hypot(*size_px))


def long_lines_within(lines: Points, area: Bools, size_px: tuple[int, int]) -> Points:
    """Return the ends (m, 2, 2) of the parts of `lines` (n, 2, 2) in an `area` (h, w) that are long in it.

    The area is the picture of that size, or the picture made smaller.
    """
    box, cell = cv2.boundingRect(area.astype(np.uint8)), np.divide(size_px, area.shape[::-1])
    least = max(_LONG * float(np.hypot(*(cell * box[2:]))), _SHORTEST * float(np.hypot(*size_px)))
    found = []
    for a, b in lines[lengths_of(lines) > least]:
        steps = np.linspace(0, 1, 2 + int(np.abs((b - a) / cell).max()))
        x, y = ((a + (b - a) * steps[:, None] + 0.5) / cell).astype(np.int64).T
        inside = area[np.clip(y, 0, area.shape[0] - 1), np.clip(x, 0, area.shape[1] - 1)]
        starts, stops = np.flatnonzero(np.diff(inside, prepend=False, append=False)).reshape(-1, 2).T
        found += [(a + (b - a) * steps[i], a + (b - a) * steps[j - 1]) for i, j in zip(starts, stops, strict=True)]
    parts = np.reshape(found, (-1, 2, 2))
    return np.asarray(parts[lengths_of(parts) > least])


def _reaching_the_frame(lines: Points, size: Points) -> Points:
    """Return lines (n, 2, 2), those that end beside the frame of a picture of that size drawn on to it."""
    middle, half = lines.mean(axis=1), (lines[:, 1] - lines[:, 0]) / 2
    low, high = -0.5 - middle, size - 0.5 - middle
    with np.errstate(divide="ignore"):
        ahead = np.where(half > 0, high / half, np.where(half < 0, low / half, np.inf)).min(axis=1)
        behind = np.where(half > 0, low / half, np.where(half < 0, high / half, -np.inf)).max(axis=1)
    most = _BESIDE * float(np.hypot(*size)) / np.maximum(np.linalg.norm(half, axis=1), np.finfo(float).tiny)
    last = np.where(np.abs(ahead - 1) < most, ahead, 1)
    first = np.where(np.abs(behind + 1) < most, behind, -1)
    return np.stack([middle + first[:, None] * half, middle + last[:, None] * half], axis=1)
