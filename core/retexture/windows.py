"""Windows of a picture: what is known of a part of it need not take memory for the rest."""

from typing import TypeAlias, TypeVar

import numpy as np

from core.arrays import Bools, Pixels, Singles

Window: TypeAlias = tuple[slice, slice]
"""Rows and columns."""
P = TypeVar("P", Singles, Pixels, Bools)


def window_around(mask: Bools, margin: int = 0) -> Window:
    """Return the window that holds a mask (H, W), and `margin` pixels all around; an empty one if nothing is marked."""
    sides = []
    for axis in (1, 0):
        marked = np.flatnonzero(mask.any(axis=axis))
        sides.append(slice(max(marked[0] - margin, 0), int(marked[-1]) + 1 + margin) if len(marked) else slice(0))
    return sides[0], sides[1]


def place_in(window: Window, part: P, shape: tuple[int, ...]) -> P:
    """Return an array of `shape`, (H, W) or (H, W, C), with `part` in a window and 0 elsewhere.

    The system gives memory only to what is written of it.
    """
    whole = np.zeros(shape, part.dtype)
    whole[window] = part
    return whole


def mirrored_span(low: int, high: int, size: int) -> slice:
    """Return which of `size` pixels in a row show those from `low` to `high`, the border being a mirror."""
    if low < 0:
        low, high = 0, max(high, -low)
    if high >= size:
        low, high = max(min(low, 2 * (size - 1) - high), 0), size - 1
    return slice(low, high + 1)
