"""Edits of piecewise cubic Bezier curves as an artist makes them: functions from control points to control points.

A curve of k segments is (3k + 1, 2): knots at 0, 3, 6, ..., a handle on either side of each. A closed curve ends where
it begins; its last knot is its first. Numbers of knots run from 0; `corners` holds those at which the curve may turn.
"""

from collections.abc import Set as AbstractSet

import numpy as np

from core.arrays import Floats, InputError, Points
from core.curves.bezier import Curve

LEAST_BEND = 0.1
"""A curve is bent as if gripped at least so far, by parameter, from its knots, where the handles have no leverage."""


def knots_of(points: Points, *, closed: bool) -> int:
    """Return how many knots there are."""
    return len(points) // 3 + (not closed)


def handles_at(points: Points, knot: int, *, closed: bool) -> tuple[int | None, int | None]:
    """Return the numbers of the control points before and after a knot; None where the curve ends."""
    last = len(points) - 1
    before, after = 3 * knot - 1, 3 * knot + 1
    if closed:
        return (last - 1 if knot == 0 else before), after
    return (before if before > 0 else None), (after if after < last else None)


def points_of(points: Points, knots: AbstractSet[int], *, closed: bool) -> list[int]:
    """Return the numbers of the control points that belong to knots, a closed curve's doubled end included."""
    numbers = {3 * knot for knot in knots}
    for knot in knots:
        numbers.update(n for n in handles_at(points, knot, closed=closed) if n is not None)
    if closed and 0 in knots:
        numbers.add(len(points) - 1)
    return sorted(numbers)


def knot_beside(points: Points, handle: int, *, closed: bool) -> int:
    """Return the knot that the control point `handle` belongs to."""
    knot = (handle + 1) // 3
    return knot % knots_of(points, closed=closed)


def with_knots_moved(points: Points, knots: AbstractSet[int], by: Points, *, closed: bool) -> Points:
    """Return the curve with knots and their handles moved by (2,)."""
    result = points.copy()
    for knot in knots:
        numbers = [n for n in (*handles_at(points, knot, closed=closed), 3 * knot) if n is not None]
        result[numbers] = points[numbers] + by
    return _join(result, closed=closed)


def with_handle_at(points: Points, handle: int, place: Points, *, closed: bool, linked: bool) -> Points:
    """Return the curve with a handle at `place`; where `linked`, the one across the knot turns along."""
    result = points.copy()
    result[handle] = place
    knot = knot_beside(points, handle, closed=closed)
    other = next((n for n in handles_at(points, knot, closed=closed) if n not in (None, handle)), None)
    if linked and other is not None:
        centre = points[3 * knot]
        length, reach = np.hypot(*(points[other] - centre)), np.hypot(*(place - centre))
        if reach > 0:
            result[other] = centre - (place - centre) * (length / reach)
    return result


def bent(
    points: Points, t: float, by: Points, *, closed: bool = False, smooth: AbstractSet[int] = frozenset()
) -> Points:
    """Return the curve with the point at parameter `t` moved by (2,), its knots held.

    With B1 = 3u(1-u)² and B2 = 3u²(1-u), the handles move by B1, B2 / (B1² + B2²) of it: the least move that does it.
    At `smooth` knots the handles across turn along.
    """
    segment = min(int(t), len(points) // 3 - 1)
    u = float(np.clip(t - segment, LEAST_BEND, 1 - LEAST_BEND))
    lever = np.array([3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u)])
    result = points.copy()
    handles = 3 * segment + 1, 3 * segment + 2
    result[[*handles]] += np.outer(lever / (lever @ lever), by)
    for handle in handles:
        linked = knot_beside(points, handle, closed=closed) in smooth
        result = with_handle_at(result, handle, result[handle], closed=closed, linked=linked)
    return result


def without_knot(points: Points, knot: int, *, closed: bool) -> Points | None:
    """Return the curve without a knot, its neighbours' handles stretched to the new distance; None if none is left."""
    count = knots_of(points, closed=closed)
    if count <= 2:
        return None
    if closed:
        turned = np.concatenate([points[3 * knot : -1], points[: 3 * knot + 1]])
        return _join(np.concatenate([_merge(turned[-4:], turned[:4]), turned[4:-4], turned[-4:-3]]), closed=True)
    if knot in (0, count - 1):
        return points[3:] if knot == 0 else points[:-3]
    at = 3 * knot
    merged = _merge(points[at - 3 : at + 1], points[at : at + 4])
    return np.concatenate([points[: at - 3], merged, points[at + 4 :]])


def corners_without(corners: AbstractSet[int], knot: int) -> frozenset[int]:
    """Return the corners' numbers after a knot has gone."""
    return frozenset(number - (number > knot) for number in corners if number != knot)


def corners_with(corners: AbstractSet[int], knot: int) -> frozenset[int]:
    """Return the corners' numbers after a smooth knot has come to stand at `knot`."""
    return frozenset(number + (number >= knot) for number in corners)


def smooth_knot(points: Points, knot: int, *, closed: bool) -> Points:
    """Return the curve with the handles of a knot in one line, parallel to its neighbours' chord."""
    before, after = handles_at(points, knot, closed=closed)
    count = knots_of(points, closed=closed)
    centre, result = points[3 * knot], points.copy()
    previous = points[3 * ((knot - 1) % count)] if closed or knot > 0 else centre
    following = points[3 * ((knot + 1) % count)] if closed or knot < count - 1 else centre
    chord = following - previous
    length = np.hypot(*chord)
    if length == 0:
        return points
    for number, side, neighbour in ((before, -1, previous), (after, 1, following)):
        if number is not None:
            result[number] = centre + side * chord / length * np.hypot(*(neighbour - centre)) / 3
    return result


def make_corner(points: Points, knot: int, *, closed: bool) -> Points:
    """Return the curve with straight ends at a knot: its handles lie towards its neighbours."""
    result, count = points.copy(), knots_of(points, closed=closed)
    for number, step in zip(handles_at(points, knot, closed=closed), (-1, 1), strict=True):
        if number is not None:
            neighbour = points[3 * ((knot + step) % count)]
            result[number] = points[3 * knot] + (neighbour - points[3 * knot]) / 3
    return result


def is_straight(before: Points, centre: Points, after: Points) -> bool:
    """Return whether two handles lie in one line, on either side of their knot."""
    a, b = centre - before, after - centre
    scale = np.hypot(*a) * np.hypot(*b)
    return bool(scale > 0 and a @ b > 0 and abs(a[0] * b[1] - a[1] * b[0]) < 0.02 * scale)


def through(line: Points, u: Floats) -> Points:
    """Return the cubic (4, 2) from the first to the last point of `line` (n, 2) that is nearest to it at `u` (n,).

    With B1 = 3u(1-u)², B2 = 3u²(1-u) and r what the line is beyond its ends' part, [B1 B2] (p1, p2)' = r in the least
    squares sense.
    """
    ends = np.outer((1 - u) ** 3, line[0]) + np.outer(u**3, line[-1])
    basis = np.column_stack([3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u)])
    handles = np.linalg.lstsq(basis, line - ends, rcond=None)[0]
    return np.concatenate([line[:1], handles, line[-1:]])


def map_along(points: Points, line: Points) -> Points:
    """Return the curve (3k + 1, 2) that follows `line`, the images of `samples_of(points)` under some map."""
    per = len(line) // (len(points) // 3)
    u = np.linspace(0, 1, per)
    cubics = [through(line[i : i + per], u) for i in range(0, len(line), per)]
    return np.concatenate([cubics[0], *(cubic[1:] for cubic in cubics[1:])])


def samples_of(points: Points, *, per_segment: int = 12) -> Points:
    """Return points of the curve, both ends of every segment included, segment by segment."""
    t = np.arange(len(points) // 3)[:, None] + np.linspace(0, 1, per_segment)
    curve = curve_through(points)
    return np.repeat(points[:1], t.size, axis=0) if curve is None else curve.at(t.ravel())


def curve_through(points: Points) -> Curve | None:
    """Return the curve with these control points; None where they make none, as while an artist folds it together."""
    try:
        return Curve(points)
    except InputError:
        return None


def _merge(first: Points, second: Points) -> Points:
    """Return one cubic in place of two that follow each other."""
    a, b = (np.hypot(*(cubic[3] - cubic[0])) for cubic in (first, second))
    chord = np.hypot(*(second[3] - first[0]))
    stretch = [chord / side if side > 0 else 1.0 for side in (a, b)]
    start = first[0] + (first[1] - first[0]) * stretch[0]
    end = second[3] + (second[2] - second[3]) * stretch[1]
    return np.stack([first[0], start, end, second[3]])


def _join(points: Points, *, closed: bool) -> Points:
    """Return the points with the last on the first if the curve is closed."""
    if closed:
        points[-1] = points[0]
    return points
