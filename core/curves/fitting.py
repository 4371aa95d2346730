"""Bezier segments fitted to a drawn or traced line, as few as keep within a tolerance.

Least squares after P. J. Schneider, "An algorithm for automatically fitting digitized curves" (Graphics Gems, 1990):
where a segment goes on smoothly its direction is held, and the length of its handle is sought; at an end or a corner
the handle is free. Points get parameters by chord length, those are improved by Newton steps towards the nearest point,
and a piece that stays too far off is split where it is worst. Then splits that turn out to be needless are taken back.

A line may run in several planes at once, (n, 2m): a curve and its target are fitted together, so that they keep
corresponding by parameter, and each of the m lines keeps within the tolerance.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import cast

import numpy as np

from core.arrays import Bools, Floats, InputError, Ints, Points, as_points
from core.curves.bezier import Curve

REPARAMETRISATIONS = 6
HOPELESS = 5.0
"""A segment that is off by so many tolerances at first does not come within one by better parameters."""
DIRECTION_REACH = 6
"""Directions are those of chords to points so many places away on either side."""
LONGEST_HANDLE = 1.5
"""Of the line's length; a longer one makes loops."""


@dataclass(frozen=True, eq=False)
class _Segment:
    """A cubic (4, 2m) along the points `first` to `last` of the line; `off` is how far those are from it at most."""

    first: int
    last: int
    cubic: Floats
    off: float


def fit(line: Points, *, tolerance: float = 1.5, corner_deg: float = 60.0, closed: bool = False) -> Curve:
    """Return a curve within `tolerance` px of the polyline `line` (n, 2), smooth but at turns over `corner_deg`.

    Raises `InputError` when fewer than two points are distinct.
    """
    line = as_points(line, "a line")
    moves = np.concatenate([[True], np.hypot(*np.diff(line, axis=0).T) > 1e-9]) if len(line) else np.empty(0, bool)
    line = line[moves]
    if closed and len(line) > 2 and np.hypot(*(line[0] - line[-1])) > 1e-9:
        line = np.concatenate([line, line[:1]])
    if len(line) < 2:
        raise InputError("a line of one point makes no curve")
    corners = np.flatnonzero(_corners(line, corner_deg))
    seam = direction_at_seam(line) if closed else None
    return Curve(fit_curve(line, corners, tolerance=tolerance, seam=seam)[0], closed)


def fit_curve(line: Floats, corners: Ints, *, tolerance: float, seam: Floats | None = None) -> tuple[Floats, Ints]:
    """Return control points (3k + 1, 2m) along `line` (n, 2m), and the points (k + 1,) of it that became knots.

    The curve may turn at the points numbered `corners`; at both ends it has the direction `seam` (2m,) where it has
    one.
    """
    directions = _directions(line)
    if seam is not None:
        directions[0] = directions[-1] = seam
    free = np.zeros(len(line), bool)
    free[[*corners.tolist(), *(() if seam is not None else (0, len(line) - 1))]] = True
    stops = np.unique(np.concatenate([[0], corners, [len(line) - 1]])).astype(int)
    segments: list[_Segment] = []
    for first, last in pairwise(stops):
        _split(line, directions, free, (int(first), int(last)), tolerance, segments)
    segments = _joined(line, directions, free, tolerance, segments)
    knots = np.array([segments[0].first, *(segment.last for segment in segments)])
    return np.concatenate([segments[0].cubic, *(segment.cubic[1:] for segment in segments[1:])]), knots


def _split(
    line: Floats, directions: Floats, free: Bools, span: tuple[int, int], tolerance: float, segments: list[_Segment]
) -> None:
    """Append segments along a span of the line."""
    segment = _segment(line, directions, free, span, tolerance)
    if segment.off <= tolerance or span[1] - span[0] < 2:
        segments.append(segment)
        return
    u = _chord_shares(line[span[0] : span[1] + 1])
    worst = int(np.clip(_off(segment.cubic, line[span[0] : span[1] + 1], u).argmax(), 1, span[1] - span[0] - 1))
    for piece in ((span[0], span[0] + worst), (span[0] + worst, span[1])):
        _split(line, directions, free, piece, tolerance, segments)


def _joined(
    line: Floats, directions: Floats, free: Bools, tolerance: float, segments: list[_Segment]
) -> list[_Segment]:
    """Take back the splits that are not needed, those first that cost least."""
    segments = list(segments)
    joins = [_join(line, directions, free, tolerance, a, b) for a, b in pairwise(segments)]
    while joins:
        best = min(range(len(joins)), key=lambda number: joins[number].off)
        if joins[best].off > tolerance:
            break
        segments[best : best + 2] = [joins[best]]
        del joins[best]
        for number in (best - 1, best):
            if 0 <= number < len(joins):
                joins[number] = _join(line, directions, free, tolerance, segments[number], segments[number + 1])
    return segments


def _join(
    line: Floats, directions: Floats, free: Bools, tolerance: float, before: _Segment, after: _Segment
) -> _Segment:
    """Return one segment in place of two; infinitely far off across a corner."""
    if free[before.last]:
        return _Segment(before.first, after.last, before.cubic, np.inf)
    return _segment(line, directions, free, (before.first, after.last), tolerance)


def _segment(line: Floats, directions: Floats, free: Bools, span: tuple[int, int], tolerance: float) -> _Segment:
    """Return the best cubic along a span of the line."""
    first, last = span
    part = line[first : last + 1]
    leave = None if free[first] else directions[first]
    arrive = None if free[last] else -directions[last]
    u = _chord_shares(part)
    cubic = _least_squares(part, u, leave, arrive)
    off = float(_off(cubic, part, u).max())
    best = _Segment(first, last, cubic, off)
    for _ in range(REPARAMETRISATIONS):
        if best.off <= tolerance or len(part) < 3 or off > HOPELESS * tolerance + 5:
            break
        u = _towards_nearest(cubic, part, u)
        cubic = _least_squares(part, u, leave, arrive)
        off = float(_off(cubic, part, u).max())
        if off < best.off:
            best = _Segment(first, last, cubic, off)
    return best


def _chord_shares(line: Floats) -> Floats:
    """Return the shares of its length at the points of a line, from 0 to 1."""
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)]) / max(float(steps.sum()), 1e-12)


def _off(cubic: Floats, line: Floats, u: Floats) -> Floats:
    """Return how far the points of a line (n, 2m) are from a cubic at `u`, in the plane in which they are farthest."""
    gaps = (_at(cubic, u) - line).reshape(len(line), -1, 2)
    return cast("Floats", np.linalg.norm(gaps, axis=2).max(axis=1))


def _at(cubic: Floats, u: Floats) -> Floats:
    """Return the places (n, 2m) of a cubic (4, 2m) at `u` (n,)."""
    v = 1 - u
    return np.asarray(np.stack([v**3, 3 * u * v**2, 3 * u**2 * v, u**3], axis=1) @ cubic)


def direction_at_seam(line: Floats) -> Floats:
    """Return the unit direction (2m,) in which a closed line (n, 2m) passes its seam."""
    reach = _reach(line)
    return _unit(line[reach] - line[-1 - reach])


def _directions(line: Floats) -> Floats:
    """Return unit directions (n, 2m) of a line, less sensitive to its wobble than its steps are."""
    number = np.arange(len(line))
    # Near an end the chord reaches as far to either side as there is line.
    reach = np.maximum(np.minimum(np.minimum(number, len(line) - 1 - number), _reach(line)), 1)
    ahead, behind = np.minimum(number + reach, len(line) - 1), np.maximum(number - reach, 0)
    return _unit(line[ahead] - line[behind])


def _reach(line: Floats) -> int:
    """Return over how many points to either side a direction is taken."""
    return int(np.clip((len(line) - 1) // 4, 1, DIRECTION_REACH))


def _corners(line: Points, corner_deg: float) -> Bools:
    """Return at which inner points (n,) the direction turns by more than `corner_deg`, at its local maximum."""
    if len(line) < 3:
        return np.zeros(len(line), bool)
    reach = min(4, (len(line) - 1) // 2)
    ahead, behind = np.zeros_like(line), np.zeros_like(line)
    ahead[:-reach], behind[reach:] = line[reach:] - line[:-reach], line[reach:] - line[:-reach]
    turn = np.zeros(len(line))
    inner = slice(reach, len(line) - reach)
    turn[inner] = np.degrees(np.arccos(np.clip((_unit(ahead[inner]) * _unit(behind[inner])).sum(axis=1), -1, 1)))
    window = np.lib.stride_tricks.sliding_window_view(np.pad(turn, reach), 2 * reach + 1)
    return cast("Bools", (turn > corner_deg) & (turn == window.max(axis=1)))


def _least_squares(line: Floats, u: Floats, leave: Floats | None, arrive: Floats | None) -> Floats:
    """Return the cubic (4, 2m) from the line's first to its last point whose handles are best.

    With B1 = 3u(1-u)^2, B2 = 3u^2(1-u) and r the line less the cubic without handles, B1 x + B2 y = r in the least
    squares sense; x and y are vectors, or, where a direction is held, lengths along it.
    """
    first, last = line[0], line[-1]
    b1, b2 = 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u)
    share = (1 - u) ** 3 + b1
    rest = line - share[:, None] * first - (1 - share)[:, None] * last
    span = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
    chord = last - first
    handles = _handles(b1, b2, rest, leave, arrive)
    for number, (direction, handle) in enumerate(zip((leave, arrive), handles, strict=True)):
        length, outward = float(np.linalg.norm(handle)), float(handle @ (chord if number == 0 else -chord))
        backward = handle @ direction <= 0 if direction is not None else outward < -0.5 * length * span
        # Handles that point backwards or overshoot make loops: the third of the line is always safe.
        if not 1e-3 * span < length < LONGEST_HANDLE * span or backward:
            safe = direction if direction is not None else _outward(line if number == 0 else line[::-1])
            handles[number] = safe * span / 3
    return np.array([first, first + handles[0], last + handles[1], last])


def _handles(b1: Floats, b2: Floats, rest: Floats, leave: Floats | None, arrive: Floats | None) -> list[Floats]:
    """Return the handles as vectors (2m,), by the normal equations."""
    size = rest.shape[1]
    bases = [np.eye(size) if direction is None else direction[None] for direction in (leave, arrive)]
    weights, count = (b1, b2), len(bases[0])
    normal = np.block(
        [
            [(p @ q) * (a @ b.T) for q, b in zip(weights, bases, strict=True)]
            for p, a in zip(weights, bases, strict=True)
        ]
    )
    right = np.concatenate([basis @ (weight @ rest) for weight, basis in zip(weights, bases, strict=True)])
    found = np.linalg.lstsq(normal, right, rcond=1e-10)[0]
    return [found[:count] @ bases[0], found[count:] @ bases[1]]


def _towards_nearest(cubic: Floats, line: Floats, u: Floats) -> Floats:
    """Return parameters moved towards the feet of the line's points on a cubic, still in order."""
    v = (1 - u)[:, None]
    w = u[:, None]
    side = np.diff(cubic, axis=0)
    slope = 3 * (v**2 * side[0] + 2 * w * v * side[1] + w**2 * side[2])
    gap = ((_at(cubic, u) - line) * slope).sum(axis=1)
    moved = np.clip(u - gap / np.maximum((slope**2).sum(axis=1), 1e-12), 0, 1)
    moved[0], moved[-1] = 0.0, 1.0
    return np.maximum.accumulate(moved)


def _outward(line: Floats) -> Floats:
    """Return the unit direction in which `line` leaves its first point."""
    return _unit(line[min(3, len(line) - 1)] - line[0])


def _unit(vectors: Floats) -> Floats:
    return cast("Floats", vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))
