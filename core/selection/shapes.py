"""Masks of areas with a drawn outline. Places are pixels of the picture, (x, y), centres at integers."""

import cv2
import numpy as np

from core.arrays import Bytes, Points

SHIFT = 4
"""Corners are placed to 2 ** -SHIFT pixels."""
AROUND = 96
"""Corners of an ellipse."""
FARTHEST_PX = 1e5


def fill_polygon(size_px: tuple[int, int], outline: Points) -> Bytes:
    """Return the mask (H, W) of the area inside an outline (n, 2), its edge antialiased.

    `size_px` is width and height. Fewer than three corners enclose nothing.
    """
    mask = np.zeros((size_px[1], size_px[0]), np.uint8)
    if len(outline) >= 3:
        corners = np.rint(np.clip(outline, -FARTHEST_PX, FARTHEST_PX) * 2**SHIFT).astype(np.int32)
        cv2.fillPoly(mask, [corners], (255,), cv2.LINE_AA, SHIFT)
    return mask


def rectangle_outline(a: Points, b: Points, *, along: int = 24) -> Points:
    """Return points (4 * along, 2) around the rectangle with opposite corners `a` and `b` (2,)."""
    u, zero, one = np.arange(along) / along, np.zeros(along), np.ones(along)
    x, y = np.concatenate([u, one, 1 - u, zero]), np.concatenate([zero, u, one, 1 - u])
    return np.asarray(a + np.stack([x, y], axis=1) * np.subtract(b, a))


def ellipse_outline(a: Points, b: Points) -> Points:
    """Return points (n, 2) around the ellipse in the rectangle with opposite corners `a` and `b` (2,)."""
    angle = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)
    return np.asarray((np.add(a, b) + np.stack([np.cos(angle), np.sin(angle)], axis=1) * np.subtract(b, a)) / 2)
