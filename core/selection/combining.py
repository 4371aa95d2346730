"""A selection that meets the one before it."""

from typing import Literal, TypeAlias

import numpy as np

from core.arrays import Bytes

Combining: TypeAlias = Literal["replace", "add", "subtract", "intersect"]


def combine(before: Bytes, selected: Bytes, how: Combining) -> Bytes:
    """Return what becomes of a mask (H, W) when `selected` (H, W) replaces it, or is added, cut out or crossed.

    Grey levels are shares of a pixel: the larger, or the smaller, of two counts.
    """
    if how == "replace":
        return selected
    if how == "add":
        return np.maximum(before, selected)
    return np.minimum(before, 255 - selected if how == "subtract" else selected)
