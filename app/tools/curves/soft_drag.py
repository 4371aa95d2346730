"""Pulling one point of a curve that has many: the curve gives way as a whole, and no spike stands out of it."""

import numpy as np

from core.arrays import Floats, Points
from core.curves import curve_edit

DENSE_PX = 40.0
"""Where most neighbouring points are nearer on the screen, along the curve, it gives way to one that is pulled."""
REACH = 2.5
"""So many times as far as a point is pulled, the curve gives way on either side of it."""


def is_dense(points: Points) -> bool:
    """Return whether the knots of a curve stand close to one another; `points` (3k + 1, 2) are on the screen."""
    return bool(np.median(_lengths(points)) < DENSE_PX)


def with_knot_pulled(points: Points, knot: int, by: Points, *, closed: bool) -> Points:
    """Return the curve (3k + 1, 2) with a knot moved by (2,) and the curve beside it drawn along.

    At the distance s along the curve it is moved by w(s) = (1 - (s / r)²)² of that, r the reach: at most half of the
    curve. A handle h away from its knot is moved by w ± h w', so that smooth knots stay smooth. While the neighbours
    are farther than r, they stay where they are.
    """
    lengths = _lengths(points)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    total = along[-1]
    reach = min(REACH * float(np.hypot(*by)), total / 2)
    if reach <= 0:
        return points
    off = along - along[knot]
    if closed:
        off = (off + total / 2) % total - total / 2
    share = np.clip(off / reach, -1, 1)
    weight, slope = (1 - share**2) ** 2, -4 * share * (1 - share**2) / reach
    ahead, behind = np.hypot(*(points[1::3] - points[:-1:3]).T), np.hypot(*(points[2::3] - points[3::3]).T)
    result = points.copy()
    result[::3] += np.outer(weight, by)
    result[1::3] += np.outer(weight[:-1] + slope[:-1] * ahead, by)
    result[2::3] += np.outer(weight[1:] - slope[1:] * behind, by)
    if closed:
        result[-1] = result[0]
    return result


def _lengths(points: Points) -> Floats:
    """Return the length of each segment."""
    line = curve_edit.samples_of(points).reshape(len(points) // 3, -1, 2)
    return np.asarray(np.hypot(*np.moveaxis(np.diff(line, axis=1), -1, 0)).sum(axis=1), np.float64)
