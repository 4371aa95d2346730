"""Piecewise cubic Bezier curves: evaluation, sampling, splitting, measuring.

A curve of k segments has 3k + 1 control points: knots at 0, 3, 6, ..., two handles between neighbouring knots. Its
parameter t runs from 0 to k, segment i over [i, i + 1]. With b the four points of a segment and u = t - i,

    B(u)  = (1-u)^3 b0 + 3 u (1-u)^2 b1 + 3 u^2 (1-u) b2 + u^3 b3
    B'(u) = 3 ((1-u)^2 (b1-b0) + 2 u (1-u) (b2-b1) + u^2 (b3-b2))
"""

from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np

from core.arrays import Floats, InputError, Points, as_points, readonly
from core.linalg.nearest import Nearest, close_pairs

SPEEDLESS = 1e-9
"""Below this speed, in pixels per parameter, a derivative gives no direction."""
FARTHEST_PX = 1e5
"""No picture is as large; a point farther off is a mistake, and would make a curve of endlessly many samples."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A piecewise cubic Bezier curve; `points` is (3k + 1, 2), read-only.

    A closed curve ends where it begins. Raises `InputError` for points that make no curve.
    """

    points: Points
    closed: bool = False

    def __post_init__(self) -> None:
        points = as_points(self.points, "a curve's points")
        if len(points) < 4 or len(points) % 3 != 1:
            raise InputError(f"a curve needs 3k + 1 control points (4, 7, 10, ...), not {len(points)}")
        if np.abs(points).max() > FARTHEST_PX:
            raise InputError(f"a curve's point lies more than {FARTHEST_PX:.0f} px away")
        if np.ptp(points, axis=0).max() < SPEEDLESS:
            raise InputError("all points of a curve coincide")
        if self.closed and np.hypot(*(points[0] - points[-1])) > 1e-6 * max(1.0, float(np.abs(points).max())):
            raise InputError("a closed curve must end where it begins")
        object.__setattr__(self, "points", readonly(points.copy()))

    @property
    def segments(self) -> int:
        """The number k of cubic pieces; the parameter runs from 0 to k."""
        return len(self.points) // 3

    @property
    def knots(self) -> Points:
        """The k + 1 points that the curve passes between its segments."""
        return self.points[::3]

    def at(self, t: Floats | float) -> Points:
        """Return the positions (..., 2) at parameters `t` (...)."""
        b, u = self._local(t)
        v = 1 - u
        return cast("Points", v**3 * b[0] + 3 * u * v**2 * b[1] + 3 * u**2 * v * b[2] + u**3 * b[3])

    def derivative(self, t: Floats | float) -> Points:
        """Return dB/dt (..., 2) at parameters `t` (...)."""
        b, u = self._local(t)
        v = 1 - u
        return cast("Points", 3 * (v**2 * (b[1] - b[0]) + 2 * u * v * (b[2] - b[1]) + u**2 * (b[3] - b[2])))

    def tangent(self, t: Floats | float) -> Points:
        """Return unit tangents (..., 2); where a handle lies on its knot, the direction the curve leaves it in."""
        t = np.asarray(t, np.float64)
        direction = self.derivative(t)
        reach = 1e-3
        while reach < 1 and (np.linalg.norm(direction, axis=-1) < SPEEDLESS).any():
            still = np.linalg.norm(direction, axis=-1, keepdims=True) < SPEEDLESS
            chord = self.at(np.minimum(t + reach, self.segments)) - self.at(np.maximum(t - reach, 0.0))
            direction = np.where(still, chord, direction)
            reach *= 4
        # Where a straight curve turns back, the chord over both sides is nothing, too: take those to other places.
        reach = 1e-3
        while reach < 4 * self.segments and (np.linalg.norm(direction, axis=-1) < SPEEDLESS).any():
            for side in (reach, -reach):
                still = np.linalg.norm(direction, axis=-1, keepdims=True) < SPEEDLESS
                chord = self.at(np.clip(t + side, 0.0, self.segments)) - self.at(t)
                direction = np.where(still, np.sign(side) * chord, direction)
            reach *= 4
        return cast("Points", direction / np.maximum(np.linalg.norm(direction, axis=-1, keepdims=True), SPEEDLESS))

    def normal(self, t: Floats | float) -> Points:
        """Return unit normals (..., 2): the tangent turned by +90 degrees, to the right of a traveller on screen."""
        tangent = self.tangent(t)
        return np.stack([-tangent[..., 1], tangent[..., 0]], axis=-1)

    def parameters(self, *, step: float = 0.5) -> Floats:
        """Return parameters, ends included, between whose points lie at most `step` px."""
        return np.concatenate([[0.0], *(i + _rungs(self, i, step) for i in range(self.segments))])

    @cached_property
    def arc(self) -> tuple[Floats, Floats]:
        """Parameters and the arc length from the start at each, in px, to convert one into the other."""
        t = self.parameters(step=max(0.25, self._chords / 20000))
        steps = np.hypot(*np.diff(self.at(t), axis=0).T)
        return t, np.concatenate([[0.0], np.cumsum(steps)])

    @property
    def length(self) -> float:
        """Arc length in px."""
        return float(self.arc[1][-1])

    def parameter_at(self, length: Floats | float) -> Floats:
        """Return the parameters at which the arc length from the start is `length` px."""
        t, s = self.arc
        return np.asarray(np.interp(length, s, t))

    def length_at(self, t: Floats | float) -> Floats:
        """Return the arc lengths from the start to parameters `t`, in px."""
        known, s = self.arc
        return np.asarray(np.interp(t, known, s))

    @property
    def box(self) -> Floats:
        """(x0, y0, x1, y1) around the curve itself, to a quarter of a pixel; its handles may lie outside."""
        dense = self.at(self.arc[0])
        return np.concatenate([dense.min(axis=0), dense.max(axis=0)])

    def nearest(self, positions: Points) -> tuple[Floats, Floats]:
        """Return the parameters of the points of the curve nearest to `positions` (n, 2), and the distances."""
        t, tree = self._tree
        _, index = tree.to(positions)
        low, high = t[np.maximum(index - 1, 0)], t[np.minimum(index + 1, len(t) - 1)]
        best = t[index]
        # The foot of the perpendicular: Newton's step on (B - q) . B' = 0 without the second derivative, kept between
        # the neighbouring samples.
        for _ in range(4):
            slope = self.derivative(best)
            gap = ((self.at(best) - positions) * slope).sum(axis=-1)
            best = np.clip(best - gap / np.maximum((slope**2).sum(axis=-1), SPEEDLESS), low, high)
        return best, np.hypot(*(self.at(best) - positions).T)

    def reversed(self) -> "Curve":
        """Return the curve run from its end to its start."""
        return Curve(self.points[::-1], self.closed)

    def insert_knot(self, t: float) -> "Curve":
        """Return the same curve with one more knot, at parameter `t` (de Casteljau)."""
        i = min(int(t), self.segments - 1)
        left, right = halves(self.points[3 * i : 3 * i + 4], t - i)
        pieces = [self.points[: 3 * i], left, right[1:], self.points[3 * i + 4 :]]
        return Curve(np.concatenate(pieces), self.closed)

    def between(self, start: float, end: float) -> "Curve":
        """Return the open piece from parameter `start` to `end`; a closed curve may be run past its seam."""
        if self.closed and end > self.segments:
            head, tail = self.between(start, self.segments), self.between(0, end - self.segments)
            return Curve(np.concatenate([head.points, tail.points[1:]]))
        first, last = min(int(start), self.segments - 1), max(int(np.ceil(end)) - 1, 0)
        points = self.points[3 * first : 3 * last + 4].copy()
        points[-4:] = halves(points[-4:], end - last)[0]
        # The last segment, if it is the first one too, has just been shortened to [0, end - last].
        share = (start - first) / (end - last) if first == last else start - first
        points[:4] = halves(points[:4], share)[1]
        return Curve(points)

    def _local(self, t: Floats | float) -> tuple[Points, Floats]:
        """Return the four control points (4, ..., 2) and the local parameter (..., 1) of parameters `t`."""
        t = np.asarray(t, np.float64)
        i = np.clip(t.astype(np.int64), 0, self.segments - 1)
        return self.points[3 * i + np.arange(4).reshape(4, *[1] * t.ndim)], (t - i)[..., None]

    @property
    def _chords(self) -> float:
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    @cached_property
    def _tree(self) -> tuple[Floats, Nearest]:
        t = self.parameters(step=max(0.5, self._chords / 20000))
        return t, Nearest(self.at(t))


def _rungs(curve: Curve, segment: int, step: float) -> Floats:
    """Return local parameters in (0, 1], ends of pieces of `segment` at most `step` px long.

    The speed is at most 3 times the longest side of the control polygon, so that many pieces suffice.
    """
    sides = np.hypot(*np.diff(curve.points[3 * segment : 3 * segment + 4], axis=0).T)
    count = max(int(np.ceil(3 * float(sides.max()) / step)), 1)
    return np.arange(1, count + 1) / count


def halves(segment: Points, u: float) -> tuple[Points, Points]:
    """Split the four points of one cubic at `u` and return both cubics (de Casteljau)."""
    level, left, right = segment, [segment[0]], [segment[-1]]
    while len(level) > 1:
        level = (1 - u) * level[:-1] + u * level[1:]
        left.append(level[0])
        right.append(level[-1])
    return np.array(left), np.array(right[::-1])


def pair_parameters(source: Curve, target: Curve, *, step: float = 0.5) -> tuple[Floats, Floats]:
    """Return parameters of two corresponding curves, as many on both, so that neither leaves a gap over `step` px.

    Curves of as many segments correspond by parameter, others by the share of their length (DPD sec. 3.1).
    """
    if source.segments == target.segments:
        rungs = (max(_rungs(source, i, step), _rungs(target, i, step), key=len) for i in range(source.segments))
        t = np.concatenate([[0.0], *(i + part for i, part in enumerate(rungs))])
        return t, t
    count = int(np.ceil(max(source.length, target.length) / step)) + 1
    share = np.linspace(0, 1, count)
    return source.parameter_at(share * source.length), target.parameter_at(share * target.length)


def crossings(a: Curve, b: Curve) -> Floats:
    """Return the parameters (n, 2) on `a` and on `b` at which they cross; on one curve itself, each pair once.

    A touch without crossing is none. Exact to about a thousandth of a pixel.
    """
    ta, tb = a.parameters(step=1.0), b.parameters(step=1.0)
    pa, pb = a.at(ta), b.at(tb)
    i, j = close_pairs((pa[1:] + pa[:-1]) / 2, (pb[1:] + pb[:-1]) / 2, 1.0)
    if a is b:
        apart = (j - i > 1) & ~(a.closed & (i == 0) & (j == len(tb) - 2))
        i, j = i[apart], j[apart]
    share = _chord_crossings(pa[i], pa[i + 1] - pa[i], pb[j], pb[j + 1] - pb[j])
    hit = ((share >= 0) & (share < 1)).all(axis=1)
    i, j, share = i[hit], j[hit], share[hit]
    return np.column_stack([ta[i] + share[:, 0] * (ta[i + 1] - ta[i]), tb[j] + share[:, 1] * (tb[j + 1] - tb[j])])


def _chord_crossings(p: Points, r: Points, q: Points, s: Points) -> Floats:
    """Return (n, 2) shares u, v with p + u r = q + v s; infinite where the chords are parallel."""
    cross = r[:, 0] * s[:, 1] - r[:, 1] * s[:, 0]
    cross = np.where(np.abs(cross) < 1e-12, np.nan, cross)
    gap = q - p
    u = (gap[:, 0] * s[:, 1] - gap[:, 1] * s[:, 0]) / cross
    v = (gap[:, 0] * r[:, 1] - gap[:, 1] * r[:, 0]) / cross
    return np.nan_to_num(np.column_stack([u, v]), nan=np.inf)
