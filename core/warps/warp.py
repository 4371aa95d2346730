"""What a warp is, and the ways to join warps."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from core.arrays import InputError, Points

Warp: TypeAlias = Callable[[Points], Points]
"""W of FAT sec. 2: positions (..., 2) in pixels of the image to positions in pixels, R² to R². Any callable will do."""


_AT_HAND = 1 << 14
"""Points whose coordinates take a quarter of a megabyte."""


def identity(points: Points) -> Points:
    """Leave every point where it is."""
    return points.copy()


def compose(*warps: Warp) -> Warp:
    """Return the warp that applies `warps` one after the other, the first one first."""

    def composed(points: Points) -> Points:
        for warp in warps:
            points = warp(points)
        return points

    return composed if len(warps) != 1 else warps[0]


def in_parts(warp: Warp, points: Points) -> Points:
    """Return what `warp` makes of points (..., 2), of so few at a time that what is on the way stays at hand."""
    all_ = points.reshape(-1, 2)
    found = np.empty_like(all_)
    for first in range(0, len(all_), _AT_HAND):
        part = np.s_[first : first + _AT_HAND]
        found[part] = warp(all_[part])
    return found.reshape(points.shape)


def resize(size_px: tuple[int, int], new_size_px: tuple[int, int]) -> Warp:
    """Return the warp that stretches a picture of `size_px`, (width, height), to `new_size_px`.

    Outer edges go to outer edges: -0.5 stays, W - 0.5 goes to W' - 0.5.
    """
    if min(*size_px, *new_size_px) < 1:
        raise InputError(f"size {new_size_px[0]}x{new_size_px[1]}: must be at least 1x1")
    scale = np.array(new_size_px, np.float64) / np.array(size_px, np.float64)

    def resized(points: Points) -> Points:
        return (points + 0.5) * scale - 0.5

    return resized
