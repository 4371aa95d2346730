"""Edits that a curve and its target undergo together: functions from `CurvePair` to `CurvePair`."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from core.arrays import Points
from core.curves import curve_edit
from core.curves.bezier import Curve
from core.document.document import CurvePair


def knots_of(pair: CurvePair) -> int:
    """Return how many knots the curve has."""
    return curve_edit.knots_of(pair.source, closed=pair.closed)


def insert(pair: CurvePair, t: float) -> CurvePair:
    """Return the same curves with one more knot on both, at parameter `t`."""
    source, target = (Curve(points, pair.closed).insert_knot(t).points for points in (pair.source, pair.target))
    return replace(pair, source=source, target=target, corners=curve_edit.corners_with(pair.corners, int(t) + 1))


def without_knot(pair: CurvePair, knot: int) -> CurvePair | None:
    """Return the curves without a knot; None if none is left."""
    source = curve_edit.without_knot(pair.source, knot, closed=pair.closed)
    target = curve_edit.without_knot(pair.target, knot, closed=pair.closed)
    if source is None or target is None:
        return None
    return replace(pair, source=source, target=target, corners=curve_edit.corners_without(pair.corners, knot))


def with_corner_toggled(pair: CurvePair, knot: int, sides: Sequence[Literal["source", "target"]]) -> CurvePair:
    """Return the curves with a corner made smooth, or a smooth knot made a corner, by the handles of `sides`."""
    edit = curve_edit.smooth_knot if knot in pair.corners else curve_edit.make_corner
    source, target = (
        edit(points, knot, closed=pair.closed) if side in sides else points
        for side, points in (("source", pair.source), ("target", pair.target))
    )
    return replace(pair, source=source, target=target, corners=pair.corners ^ {knot})


def with_corner(pair: CurvePair, knot: int) -> CurvePair:
    """Return the curves free to turn at a knot; no point moves."""
    return replace(pair, corners=pair.corners | {knot})


def close(pair: CurvePair) -> CurvePair:
    """Return the curves with a straight segment from their ends to their beginnings."""
    if pair.closed:
        return pair
    last = knots_of(pair) - 1
    source, target = (_with_straight_end(points) for points in (pair.source, pair.target))
    return replace(pair, source=source, target=target, closed=True, corners=pair.corners | {0, last})


def open_up(pair: CurvePair) -> CurvePair:
    """Return the curves without their last segment; a curve of two knots stays closed."""
    if not pair.closed or knots_of(pair) <= 2:
        return pair
    return replace(pair, source=pair.source[:-3], target=pair.target[:-3], closed=False)


def _with_straight_end(points: Points) -> Points:
    first, last = points[0], points[-1]
    return np.concatenate([points, [last + (first - last) / 3, last + (first - last) * 2 / 3, first]])
