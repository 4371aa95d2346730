"""Which of some points are nearest to others, or near them at all."""

import cv2
import numpy as np

from core.arrays import Floats, Ints, Points

_SINGLE_TREE = 4
"""FLANN's number of its exact search, in one k-d tree."""


class Nearest:
    """Finds the nearest of `points` (n, 2), at least one."""

    def __init__(self, points: Points) -> None:
        self._points = points
        # FLANN goes on reading the array that it is given.
        self._rounded = np.ascontiguousarray(points, np.float32)
        self._index = cv2.flann_Index(self._rounded, {"algorithm": _SINGLE_TREE})  # type: ignore[attr-defined]

    def to(self, positions: Points) -> tuple[Floats, Ints]:
        """Return the distances (m,) of `positions` (m, 2) to the nearest points, and their numbers.

        Of points whose distances differ by rounding to single precision either may be taken.
        """
        if not len(positions):
            return np.empty(0), np.empty(0, np.int64)
        found, _ = self._index.knnSearch(np.ascontiguousarray(positions, np.float32), 1, params={"checks": -1})
        number = np.asarray(found, np.int64)[:, 0]
        gap = positions - self._points[number]
        return np.hypot(gap[:, 0], gap[:, 1]), number


def close_pairs(a: Points, b: Points, distance: float) -> tuple[Ints, Ints]:
    """Return the numbers (k,) in `a` (n, 2) and in `b` (m, 2) of pairs that may lie within `distance`, in order of `a`.

    All that do are among them; none lies farther apart than three times as much.
    """
    cells = [np.floor(points / distance).astype(np.int64) for points in (a, b)]
    low = np.minimum(cells[0].min(axis=0), cells[1].min(axis=0)) - 1
    high = max(int(cell[:, 1].max()) for cell in cells) + 2 - low[1]
    mine, theirs = ((cell - low) @ [high, 1] for cell in cells)
    order = np.argsort(theirs, kind="stable")
    sorted_cells, columns = theirs[order], mine[:, None] + high * np.arange(-1, 2)
    # The three cells of one column follow one another.
    first, after = sorted_cells.searchsorted(columns - 1, "left"), sorted_cells.searchsorted(columns + 1, "right")
    count = (after - first).ravel()
    within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    return np.repeat(np.arange(len(a)), (after - first).sum(axis=1)), order[np.repeat(first.ravel(), count) + within]
