"""The output canvas: which part of the plane becomes the picture that is written."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from core.arrays import InputError, Points

Framing: TypeAlias = Literal["picture", "warp"]
"""What a file shows: the frame that the picture had, or all of the warped picture."""
MOST_SIDE_PX = 65_536
MOST_PIXELS = 2**30
_TOLERANCE_PX = 1e-6
"""An edge that lies on a pixel border but for rounding adds no row of pixels."""
_CLEAR_PX = 4
"""A pixel so far from a cell has nothing of it."""
_LATTICE = 512


@dataclass(frozen=True)
class Canvas:
    """A whole number of pixels, the first of which is centred at `origin` of the plane.

    Raises `InputError` for a size that no picture can have.
    """

    width_px: int
    height_px: int
    origin: tuple[int, int] = (0, 0)

    def __post_init__(self) -> None:
        width, height = self.width_px, self.height_px
        if min(width, height) < 1 or max(width, height) > MOST_SIDE_PX or width * height > MOST_PIXELS:
            raise InputError(
                f"output of {width}x{height} pixels: must have 1 to {MOST_SIDE_PX} a side, {MOST_PIXELS} in all"
            )

    @classmethod
    def of(cls, framing: Framing, positions: Points, size_px: tuple[int, int]) -> "Canvas":
        """Return the canvas for a warped grid (R, C, 2) whose frame has a width and height of `size_px`."""
        return cls.around(positions) if framing == "warp" else cls(*size_px)

    @classmethod
    def around(cls, positions: Points) -> "Canvas":
        """Return the smallest canvas that holds all of a warped grid (R, C, 2), whose edge is the picture's edge."""
        flat = positions.reshape(-1, 2)
        low = np.floor(flat.min(axis=0) + 0.5 + _TOLERANCE_PX)
        high = np.maximum(np.ceil(flat.max(axis=0) + 0.5 - _TOLERANCE_PX), low + 1)
        if not np.abs([low, high]).max() < 2**31:
            raise InputError("output: the warped picture reaches out of all bounds")
        (left, top), (width, height) = low, high - low
        return cls(int(width), int(height), (int(left), int(top)))

    @property
    def size(self) -> tuple[int, int]:
        """Width and height."""
        return self.width_px, self.height_px

    def placed(self, positions: Points) -> Points:
        """Return positions (..., 2) of the plane in pixels of the canvas."""
        return positions - self.origin


def has_gaps(positions: Points, size_px: tuple[int, int]) -> bool:
    """Return whether a warped grid (R, C, 2), in pixels of the result, plainly leaves some of its pixels empty.

    Asked are pixels of a lattice with up to 512 a side, each against the boxes around all cells: where one is in none,
    it is empty for certain. Gaps that are narrower than the lattice or a cell may be missed.
    """
    corners = positions[:-1, :-1], positions[:-1, 1:], positions[1:, :-1], positions[1:, 1:]
    step = -(-np.array(size_px) // _LATTICE)
    count = -(-np.array(size_px) // step)
    low = np.ceil((np.minimum.reduce(corners).reshape(-1, 2) - _CLEAR_PX) / step)
    high = np.floor((np.maximum.reduce(corners).reshape(-1, 2) + _CLEAR_PX) / step) + 1
    left, top = np.clip(low, 0, count).astype(int).T
    right, bottom = np.clip(np.maximum(low, high), 0, count).astype(int).T
    boxes = np.zeros((count[1] + 1, count[0] + 1), int)
    for rows, columns, sign in ((top, left, 1), (top, right, -1), (bottom, left, -1), (bottom, right, 1)):
        np.add.at(boxes, (rows, columns), sign)
    return bool((boxes.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] == 0).any())
