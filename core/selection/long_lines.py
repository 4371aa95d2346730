"""Long straight lines of a picture: horizons, walls, masts.

By the line segment detector (R. Grompone von Gioi, J. Jakubowicz, J.-M. Morel and G. Randall, "LSD: a line segment
detector", 2012), at a size at which what is small does not break them.
"""

import cv2
import numpy as np

from core.arrays import Points
from core.imaging.image import Image
from core.imaging.proxy import proxy, scale_for

_PIXELS = 320_000
"""Pictures are looked at with about so many pixels."""
_LONG, _BORDER = 0.1, 0.01
"""Shares of the picture's diagonal: what is long, and how near to a side of the frame a line is the frame's."""
_BESIDE = 0.02
"""Such a share, too: a line that ends so near to the frame goes on to it."""


def find_long_lines(image: Image) -> Points:
    """Return the ends (n, 2, 2) of the long straight lines of a picture, in its pixels, the longest first."""
    looked = proxy(image, scale_for(image, _PIXELS))
    found = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD).detect(cv2.cvtColor(looked, cv2.COLOR_RGB2GRAY))[0]
    if found is None:
        return np.empty((0, 2, 2))
    size = np.array(image.size_px, np.float64)
    lines = _reaching_the_frame((np.reshape(found, (-1, 2, 2)) + 0.5) * (size / looked.shape[1::-1]) - 0.5, size)
    diagonal = float(np.hypot(*size))
    border, last = _BORDER * diagonal, size - 1 - _BORDER * diagonal
    beside = np.all(lines < border, axis=1) | np.all(lines > last, axis=1)
    lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    chosen = np.flatnonzero((lengths > _LONG * diagonal) & ~np.any(beside, axis=1))
    order = chosen[np.argsort(-lengths[chosen], kind="stable")]
    return np.asarray(np.clip(lines[order], -0.5, size - 0.5))


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
