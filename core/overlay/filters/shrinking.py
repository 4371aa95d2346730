"""A picture made smaller by a whole number, and where its points lie then."""

import numpy as np

from core.arrays import Bools, Floats, Points, Singles

WORKING_PX = 800
"""Longest side of the picture that is searched and registered; larger ones are shrunk for that by a whole number."""


def working_scale(shape: tuple[int, ...]) -> int:
    """Return how much smaller a picture of a shape (H, W, ...) is searched."""
    return -(-max(shape[:2]) // WORKING_PX)


def scale_between(rows: int, small_rows: int) -> int:
    """Return how much smaller a picture of so many rows was made, by the rows that it has now."""
    return -(-rows // small_rows)


def shrunk(image: Floats | Singles | Bools, scale: int) -> Floats:
    """Return the means (h, w, C) of squares of `scale` pixels; past the picture's edge its last pixels are repeated."""
    if scale == 1:
        return image.astype(np.float64, copy=False)
    total = np.zeros((*(-(-n // scale) for n in image.shape[:2]), image.shape[2]))
    for first in np.ndindex(scale, scale):
        ends = zip(first, image.shape[:2], strict=True)
        places = (np.minimum(np.arange(k, n + k, scale)[: -(-n // scale)], n - 1) for k, n in ends)
        total += image[np.ix_(*places)]
    return total / scale**2


def shrunk_mask(mask: Bools, scale: int) -> Bools:
    """Return which squares of `scale` pixels of a mask (H, W) are marked for the most part: (h, w)."""
    return mask if scale == 1 else np.asarray(shrunk(mask[..., None], scale)[..., 0] > 0.5, np.bool_)


def to_small(points: Points, scale: int) -> Points:
    """Return where points of a picture lie in the picture that `shrunk` makes."""
    return (points - (scale - 1) / 2) / scale
