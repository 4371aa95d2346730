"""A frame that stays a rectangle: where the features go that it cuts, and how its nodes glide beside them.

Where W takes the frame to a rectangle, the picture fills it to the last pixel. A feature that a side cuts keeps its
shape exactly and stays on that side: it does not turn (α is real and positive), it slides along the side, and two
opposite sides give it its size. The other nodes of the frame glide along their side so that they keep their order.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints, Points
from core.grid import Grid
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.pose import Solution
from core.mapping.features.similarity import Body
from core.mapping.handles.constraints import Constraints
from core.mapping.handles.frame_glide import glide_beside
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.tolerances import LITTLE, ROUNDING

LEFT, TOP, RIGHT, BOTTOM = range(4)
_AT_ONCE = 256
"""Points whose distances from a line are worked out together."""


@dataclass(frozen=True)
class Rectangle:
    """The sides that W takes the frame to, in output pixels."""

    sides: tuple[float, float, float, float]
    """x of the left, y of the top, x of the right and y of the bottom side."""

    @classmethod
    def of(cls, w: Complexes) -> "Rectangle | None":
        """Return the rectangle that W takes the frame of a grid (R, C) to, or None if it is another shape."""
        left, top, right, bottom = (float(x) for x in (w[0, 0].real, w[0, 0].imag, w[-1, -1].real, w[-1, -1].imag))
        size = max(right - left, bottom - top)
        off = (w[:, 0].real - left, w[0].imag - top, w[:, -1].real - right, w[-1].imag - bottom)
        if min(right - left, bottom - top) <= 0 or max(np.abs(side).max() for side in off) > ROUNDING * size:
            return None
        return cls((left, top, right, bottom))

    def holds(self, z: Complexes) -> bool:
        """Return whether positions (n,) lie within the sides."""
        left, top, right, bottom = self.sides
        slack = ROUNDING * max(right - left, bottom - top)
        across, down = (z.real - left, right - z.real), (z.imag - top, bottom - z.imag)
        return bool(min(part.min(initial=np.inf) for part in (*across, *down)) >= -slack)

    def cover(self, mapping: FeatureMapping) -> Solution:
        """Return the picture scaled as a whole so that it covers the rectangle, and reaches beyond it at two sides.

        That is left where a feature between two opposite sides, which give it its size, is larger than the rectangle
        the other way: its shape and the full canvas are kept, the frame is not.
        """
        left, top, right, bottom = self.sides
        rest = as_complex(mapping.grid.nodes)
        size = rest[-1, -1] - rest[0, 0]
        alpha = max((right - left) / size.real, (bottom - top) / size.imag)
        z = alpha * (rest - rest.mean()) + complex(left + right, top + bottom) / 2
        t = np.array([z.ravel()[body.nodes].mean() for body in mapping.bodies], np.complex128)
        return Solution(z, np.full(len(t), complex(alpha)), t)

    def stretches(self, grid: Grid) -> bool:
        """Return whether its sides are not in the proportion of the picture's."""
        left, top, right, bottom = self.sides
        return abs((right - left) * grid.height_px / ((bottom - top) * grid.width_px) - 1) > ROUNDING


def sides_cut(mapping: FeatureMapping) -> Bools:
    """Return which of the four sides of the frame cut which body of a mapping (n, 4)."""
    cut, index = np.zeros((len(mapping.bodies), 4), bool), mapping.index
    for side, line in ((LEFT, index[:, 0]), (TOP, index[0]), (RIGHT, index[:, -1]), (BOTTOM, index[-1])):
        cut[line[line >= 0], side] = True
    return cut


def pivot_of(cut: Bools, rest: Complexes, middle: complex) -> complex:
    """Return a point (of the picture) that a body with its centroid at `middle` may keep on the sides that cut it."""
    x = rest[0, 0].real if cut[LEFT] else rest[-1, -1].real if cut[RIGHT] else middle.real
    y = rest[0, 0].imag if cut[TOP] else rest[-1, -1].imag if cut[BOTTOM] else middle.imag
    return complex(x, y)


def freedom_of(cut: Bools) -> Bools:
    """Return which of a body's size, turn, move along x and move along y the sides that cut it leave open."""
    across, down = cut[LEFT] | cut[RIGHT], cut[TOP] | cut[BOTTOM]
    opposite = (cut[LEFT] & cut[RIGHT]) | (cut[TOP] & cut[BOTTOM])
    return np.array([not opposite, not cut.any(), not across, not down])


def slide(
    body: Body, cut: Bools, rest: Complexes, rectangle: Rectangle, scale: float, near: complex
) -> tuple[complex, complex]:
    """Return the (α, t) of a cut body that lies on its sides, with its centroid as near as may be to `near`.

    Opposite sides that cut it give its size in place of `scale`; where both pairs do, and ask for different sizes, it
    takes the larger one and lies in the middle. Else it is no larger than what fits between the sides.
    """
    left, top, right, bottom = rectangle.sides
    middle = rest.ravel()[body.nodes].mean()
    axes = [
        _Axis(cut[LEFT], cut[RIGHT], rest[0, 0].real, rest[-1, -1].real, left, right, middle.real, body.arms.real),
        _Axis(cut[TOP], cut[BOTTOM], rest[0, 0].imag, rest[-1, -1].imag, top, bottom, middle.imag, body.arms.imag),
    ]
    forced = [axis.stretch for axis in axes if axis.first and axis.last]
    scale = max(forced) if forced else min(scale, *(axis.most for axis in axes))
    return complex(scale), complex(axes[0].place(scale, near.real), axes[1].place(scale, near.imag))


@dataclass(frozen=True)
class _Axis:
    """A body between two opposite sides of a rectangle, along one axis."""

    first: bool
    last: bool
    """Which of them cut it."""
    rest_first: float
    rest_last: float
    """The sides on the picture."""
    there_first: float
    there_last: float
    """And where they go."""
    middle: float
    """The body's centroid on the picture."""
    arms: Floats
    """Its nodes, from there."""

    @property
    def stretch(self) -> float:
        """The size of a body that both sides cut."""
        return (self.there_last - self.there_first) / (self.rest_last - self.rest_first)

    @property
    def _gaps(self) -> tuple[float, float]:
        """What is left free at least, before and behind the body, in output pixels."""
        before = self.middle + self.arms.min() - self.rest_first
        behind = self.rest_last - self.middle - self.arms.max()
        return LITTLE * self.stretch * float(before), LITTLE * self.stretch * float(behind)

    @property
    def most(self) -> float:
        """The largest size that fits."""
        return (self.there_last - self.there_first - sum(self._gaps)) / float(np.ptp(self.arms) or 1)

    def place(self, scale: float, near: float) -> float:
        """Return where the centroid lies: on the side that cuts the body, or as near as fits to `near`."""
        from_first = self.there_first + scale * (self.middle - self.rest_first)
        from_last = self.there_last - scale * (self.rest_last - self.middle)
        if self.first or self.last:
            return (from_first + from_last) / 2 if self.first and self.last else from_first if self.first else from_last
        low, high = self._gaps
        least, most = self.there_first + low - scale * self.arms.min(), self.there_last - high - scale * self.arms.max()
        return float(np.clip(near, least, max(least, most)))


def make_room(
    bodies: list[Body], cut: Bools, alpha: Complexes, t: Complexes, w: Complexes
) -> tuple[Complexes, Complexes]:
    """Return (α, t) of all bodies (n,) with those apart, and inside the frame, that slide along the same side.

    `cut` (n, 4) says which sides cut which bodies. Along a side, bodies keep their order and leave room for the frame
    nodes between them; they are moved as little as possible in the least-squares sense (isotonic regression). Those
    that are too long together become smaller, if no opposite side gives them their size.
    """
    alpha, t = alpha.copy(), t.copy()
    rows, columns = w.shape
    number = np.arange(rows * columns).reshape(rows, columns)
    for side, line in ((TOP, number[0]), (BOTTOM, number[-1]), (LEFT, number[:, 0]), (RIGHT, number[:, -1])):
        part = np.real if side in (TOP, BOTTOM) else np.imag
        unit = 1.0 if side in (TOP, BOTTOM) else 1j
        ends = _ends_along(line, [body if c[side] else None for body, c in zip(bodies, cut, strict=True)])
        if not ends:
            continue
        order = np.array([i for i, *_ in ends])
        first, last = (np.array([end[k] for end in ends]) for k in (1, 2))
        fixed = np.array([bool(freedom_of(cut[i])[2 if side in (TOP, BOTTOM) else 3]) for i in order]) == 0
        places = part(w.ravel()[line])
        arms = [[part(bodies[i].arms[bodies[i].nodes == line[k]][0]) for k in pair] for i, *pair in ends]
        reach = np.array(arms) * np.abs(alpha[order])[:, None]
        gap = LITTLE * np.diff(places[np.stack([np.append(0, last), np.append(first, len(line) - 1)])], axis=0)[0]
        room = places[-1] - places[0] - gap.sum()
        length = (reach[:, 1] - reach[:, 0]).sum()
        if length > room and not fixed.any() and all(freedom_of(cut[i])[0] for i in order):
            alpha[order] *= room / length
            reach = reach * (room / length)
        start = part(t[order]) + reach[:, 0]
        shift = np.cumsum(gap[:-1] + np.append(0, reach[:-1, 1] - reach[:-1, 0])) + places[0]
        most = np.full(len(order), places[-1] - places[0] - gap.sum() - (reach[:, 1] - reach[:, 0]).sum())
        weights = np.where(fixed, 1e6, 1.0)
        found = scipy.optimize.isotonic_regression(start - shift, weights=weights).x
        found = np.clip(found, 0, np.maximum(most, 0)) + shift
        t[order] += unit * np.where(fixed, 0.0, found - start)
    return alpha, t


def _ends_along(line: Ints, bodies: list[Body | None]) -> list[tuple[int, int, int]]:
    """Return (index, first, last) of the bodies that have nodes on a side (k,), in the order of their middles there."""
    found = []
    for i, body in enumerate(bodies):
        if body is not None:
            there = np.flatnonzero(np.isin(line, body.nodes))
            found.append((i, int(there[0]), int(there[-1])))
    return sorted(found, key=lambda end: end[1] + end[2])


@dataclass(frozen=True, eq=False)
class Placed:
    """What a straight frame decides before all else."""

    alpha: Complexes
    t: Complexes
    bodies: Bools
    """Which bodies it cuts: their (α, t) are given."""
    frame: Complexes | None
    """Where the nodes of the frame are (R, C), if not where W has them."""

    @classmethod
    def none(cls, mapping: FeatureMapping) -> "Placed":
        """Return that no body is cut."""
        alpha, t = np.zeros((2, len(mapping.bodies)), np.complex128)
        return cls(alpha, t, np.zeros(len(alpha), bool), None)


def place_cut(mapping: FeatureMapping, w: Complexes, rectangle: Rectangle) -> Placed:
    """Return where the bodies are that a straight frame cuts.

    A body has the size that W alone would give it, and lies as near to where W has it as its sides, and the other
    bodies there, allow.
    """
    if not (mapping.index[mapping.grid.outline] >= 0).any():
        return Placed.none(mapping)
    rest = as_complex(mapping.grid.nodes)
    cut = sides_cut(mapping)
    is_cut = np.asarray(cut.any(axis=1))
    alpha, t = np.ones((2, len(cut)), np.complex128)
    for i in np.flatnonzero(is_cut):
        body = mapping.bodies[i]
        near = complex(w.ravel()[body.nodes].mean())
        alpha[i], t[i] = slide(body, cut[i], rest, rectangle, mapping.scale_alone(int(i), w), near)
    alpha, t = make_room(mapping.bodies, cut, alpha, t, w)
    z = w.copy()
    for i in np.flatnonzero(is_cut):
        z.ravel()[mapping.bodies[i].nodes] = mapping.bodies[i].place(alpha[i], t[i])
    return Placed(alpha, t, is_cut, glide_beside(z, w, mapping.index))


def constrain_frame(mapping: FeatureMapping, z: Complexes) -> Constraints:
    """Return what a held frame asks of a mapping that has it at z (R, C): straight sides let features slide."""
    rest = as_complex(mapping.grid.nodes)
    none = Constraints.none(mapping.bodies, rest)
    if Rectangle.of(z) is None:
        return none
    pivots, free = none.pivots.copy(), none.free.copy()
    for i, cut in enumerate(sides_cut(mapping)):
        pivots[i], free[i] = pivot_of(cut, rest, complex(pivots[i])), free[i] & freedom_of(cut)
    glide = mapping.grid.outline & (mapping.index < 0)
    glide[[0, 0, -1, -1], [0, -1, -1, 0]] = False
    return Constraints(none.probes, none.to, pivots, free, glide)


def distance_to_line(points: Points, line: Points) -> float:
    """Return how far the furthest of some points (n, 2) is from the line through others (m, 2); rounding is 0."""
    if not len(points):
        return 0.0
    start, along = line[:-1], np.diff(line, axis=0)
    squared = (along**2).sum(axis=1)
    worst = 0.0
    for begin in range(0, len(points), _AT_ONCE):
        apart = points[begin : begin + _AT_ONCE, None] - start
        share = np.clip((apart * along).sum(axis=2) / np.where(squared > 0, squared, 1), 0, 1)
        far = np.sqrt(((apart - share[..., None] * along) ** 2).sum(axis=2)).min(axis=1)
        worst = max(worst, float(far.max()))
    return worst if worst > ROUNDING * float(np.ptp(line, axis=0).max()) else 0.0
