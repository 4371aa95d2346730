"""The Cholesky factor of a five-point system on a grid, renewed only where the system changes  [FAT eqs. 11-13].

Boxes of the nested dissection are eliminated from the smallest up. An entry of the matrix belongs to one box; where
entries change, that box and all that hold it are eliminated again, and no other. The same goes for the first half of a
solve. Under a brush that is little: a way from a few small boxes up to the whole.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from core.arrays import Bools, Floats, Ints, SingularSystemError
from core.linalg.cubic_convolution import Complexes
from core.linalg.dissection import Group, dissect
from core.linalg.fronts import Fronts, solve_lower, solve_upper, stretch
from core.linalg.grid_solver import Onto
from core.tracing import span

_ALL_KEPT_AT_MOST = 300_000
"""Nodes of a grid up to which what boxes leave is kept from a tile on."""
_LEAST_KEPT = 16
"""Tiles from which on it is kept on larger grids, where it takes much memory."""
_BOXES_AT_ONCE = 2000
"""About so many boxes are eliminated before those that hold them all: what they leave stays in the memory at hand."""


@dataclass(frozen=True, eq=False)
class HalfColumns:
    """L⁻¹ P b of columns b (N, k) that are 0 but at a few nodes."""

    rows: Ints
    """Those that may not be 0, ascending."""
    values: Floats
    """What is there (r, k)."""
    size: int
    """How many rows there are."""

    @property
    def T(self) -> "_Transposed":  # noqa: N802
        """What multiplies others from the left."""
        return _Transposed(self)

    def __matmul__(self, shares: Floats) -> Floats:
        return HalfColumns(self.rows, self.values @ shares, self.size).whole

    def __getitem__(self, columns: Any) -> "HalfColumns":
        return HalfColumns(self.rows, self.values[columns], self.size)

    @property
    def whole(self) -> Floats:
        """All rows."""
        found = np.zeros((self.size, self.values.shape[1]))
        found[self.rows] = self.values
        return found


class _Transposed:
    """Columns that multiply from the left."""

    def __init__(self, columns: HalfColumns) -> None:
        self._columns = columns

    def __matmul__(self, other: HalfColumns | Floats) -> Floats:
        columns = self._columns
        if other is columns:
            return np.asarray(columns.values.T @ columns.values)
        whole = other.whole if isinstance(other, HalfColumns) else other
        return np.asarray(columns.values.T @ whole.take(columns.rows, axis=0))


@dataclass(frozen=True, eq=False)
class _Step:
    """What eliminates the pivots of some boxes of a group from a load."""

    fronts: Fronts
    where: Ints | slice
    """These boxes."""
    nodes: Ints
    """Their pivots (n, p)."""
    factor: Floats
    carry: Floats
    """Transposed (n, s, p)."""
    halves: list[tuple[int, Ints | slice, Ints]]
    """What is taken off before: the group, its boxes, and where their frames have the nodes of the front."""


Taken: TypeAlias = dict[int, Floats]
"""What boxes take off a load on their frames, and a 0, by the number of their group; where there is any."""


@dataclass(frozen=True, eq=False)
class _Half:
    """The first half of a solve for a load that changes little from one to the next."""

    b: Floats
    nodes: Ints
    """Where b may not be 0."""
    y: Floats
    taken: Taken


class GridFactor:
    """The Cholesky factor of a symmetric positive definite matrix with the pattern of `laplacian.pattern`.

    Nodes of the outline are to be uncoupled from all others, with the equation x = 0: every b is to be 0 there.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        self.size = shape[0] * shape[1]
        self._fronts: list[Fronts] = []
        known: dict[Group, Fronts] = {}
        count = 0
        with span("analyse", unknowns=self.size):
            for group in dissect((max(shape[0] - 2, 0), max(shape[1] - 2, 0))):
                is_kept = group.tiles >= (1 if self.size <= _ALL_KEPT_AT_MOST else _LEAST_KEPT) or not count
                known[group] = Fronts(group, shape, count, len(self._fronts), is_kept=is_kept)
                self._fronts.append(known[group])
                count += len(group.corners)
            self._halves = [[known[half] for half, _, _ in fronts.group.halves] for fronts in self._fronts]
            self._starts = np.array([*(fronts.first for fronts in self._fronts), count])
            self._find_wholes(count)
            self._put_in_order()
        self._values = np.full(3 * self.size, np.nan)
        self._renewed = np.zeros(count, bool)
        """Boxes eliminated since the last half that was kept."""
        self._last: _Half | None = None
        self._kept: tuple[Bools, list[_Step]] | None = None
        """The boxes that were touched by the last load, and the steps for them."""

    def _find_wholes(self, count: int) -> None:
        """Find out which box an entry belongs to, -1 for none, and which box every box is half of."""
        self._home = np.full(3 * self.size, -1)
        self._whole = np.full(count, -1)
        for fronts, halves in zip(self._fronts, self._halves, strict=True):
            numbers = fronts.first + np.arange(fronts.count)
            self._home[fronts.entries] = numbers[:, None]
            self._home[:3] = -1
            for half, (_, chosen, _) in zip(halves, fronts.group.halves, strict=True):
                self._whole[half.first + chosen.start : half.first + chosen.stop] = numbers
        self._unit = np.arange(count)
        """The box itself where what it leaves is kept, else the least one around it of which that is so."""
        for fronts in self._fronts:
            if not fronts.is_kept:
                boxes = slice(fronts.first, fronts.first + fronts.count)
                self._unit[boxes] = self._unit[self._whole[boxes]]

    def _put_in_order(self) -> None:
        """Give nodes their numbers in the order of elimination, those of the outline the one after the last."""
        self._inner = sum(fronts.count * fronts.pivots for fronts in self._fronts)
        self._place = np.full(self.size, self._inner)
        start = 0
        for fronts in reversed(self._fronts):
            fronts.own = slice(start, start + fronts.count * fronts.pivots)
            self._place[fronts.nodes[:, : fronts.pivots].ravel()] = np.arange(fronts.own.start, fronts.own.stop)
            start = fronts.own.stop
        for fronts, halves in zip(self._fronts, self._halves, strict=True):
            fronts.around = self._place[fronts.nodes[:, fronts.pivots :]]
            fronts.find_halves(halves)

    def factorise(self, values: Floats) -> "GridFactor":
        """Factorise new values (R, C, 3) of `laplacian.node_values` as L Lᵀ (FAT eq. 11); return the factor itself."""
        new = values.reshape(-1)
        touched = self._with_wholes(self._home[np.flatnonzero(new != self._values)])[self._unit]
        self._renewed |= touched
        self._kept = None
        with span("factor", unknowns=self.size, boxes=int(touched.sum())):
            try:
                for part in self._parts(np.flatnonzero(touched)):
                    for fronts, halves, chosen in self._up(part):
                        fronts.eliminate(new, chosen, halves)
            except np.linalg.LinAlgError:
                self._values = np.full(new.shape, np.nan)
                raise SingularSystemError(f"a system of {self.size} unknowns has no unique solution") from None
        self._values = new.copy()
        return self

    @property
    def diagonal(self) -> Floats:
        """The matrix's (N,)."""
        return self._values[::3]

    def _with_wholes(self, boxes: Ints) -> Bools:
        """Mark boxes, -1 for none, and all that hold them."""
        touched = np.zeros(len(self._whole) + 1, bool)
        touched[boxes] = True
        touched[-1] = True  # it stands for none
        boxes = np.flatnonzero(touched[:-1])
        while boxes.size:
            boxes = self._whole[boxes]
            boxes = boxes[~touched[boxes]]
            touched[boxes] = True
        return touched[:-1]

    def _parts(self, boxes: Ints) -> Iterator[Ints]:
        """Split ascending boxes into parts to be eliminated one after the other, none of them within a unit."""
        order = np.argsort(-self._unit[boxes], kind="stable")
        last_first = -self._unit[boxes][order]
        part = np.searchsorted(last_first, last_first) // _BOXES_AT_ONCE
        for chosen in np.split(order, np.flatnonzero(np.diff(part)) + 1):
            yield boxes[np.sort(chosen)]

    def _up(self, boxes: Ints) -> Iterator[tuple[Fronts, list[Fronts], Ints]]:
        """Yield fronts with some of the ascending boxes, those of their halves, and these boxes, halves first."""
        ends = np.searchsorted(boxes, self._starts).tolist()
        for k in reversed(range(len(self._fronts))):
            if ends[k] < ends[k + 1]:
                yield self._fronts[k], self._halves[k], boxes[ends[k] : ends[k + 1]] - self._fronts[k].first

    def solve(self, b: Floats) -> Floats:
        """Solve A x = b for b (N, k)."""
        return self.backward(self.forward(b).whole)

    def forward(self, b: Floats, nodes: Ints | None = None, asked: Ints | None = None) -> HalfColumns:
        """Return L⁻¹ P b, the first half of a solve (FAT eq. 12): forward(a)ᵀ forward(b) = aᵀ A⁻¹ b.

        `nodes` are those where b is not 0, by default all.
        """
        homes = np.arange(len(self._whole)) if nodes is None else self._home[3 * nodes]
        rows, values = [np.empty(0, np.int64)], [np.empty((0, b.shape[1]))]
        for step, done in self._eliminate(b, {}, self._steps(self._with_wholes(homes))):
            own, p = step.fronts.own, step.fronts.pivots
            rows.append(np.arange(own.start, own.stop).reshape(-1, p)[step.where].ravel())
            values.append(done.reshape(len(done) * p, b.shape[1]))
        return HalfColumns(np.concatenate(rows), np.concatenate(values), self._inner)

    def forward_again(self, values: Floats, nodes: Ints) -> Floats:
        """Return forward(b), b with `values` (m, k) at `nodes` and else 0: only what is not as in the last call."""
        k, last, self._last = values.shape[1], self._last, None
        if last is None or last.y.shape[1] != k:
            last = _Half(np.zeros((self.size, k)), nodes, np.zeros((self._inner, k)), {})
        both = nodes if nodes is last.nodes else np.concatenate([last.nodes, nodes])
        before = last.b.take(both, axis=0)
        last.b[last.nodes] = 0
        last.b[nodes] = values
        changed = both[(before != last.b.take(both, axis=0)).any(axis=1)]
        touched = self._with_wholes(self._home[3 * changed]) | self._renewed
        if self._kept is None or not np.array_equal(self._kept[0], touched):
            self._kept = touched, self._steps(touched)
        for step, done in self._eliminate(last.b, last.taken, self._kept[1]):
            last.y[step.fronts.own].reshape(step.fronts.count, step.fronts.pivots, k)[step.where] = done
        self._renewed[:] = False
        self._last = replace(last, nodes=nodes)
        if self.size > _ALL_KEPT_AT_MOST:
            self._kept = None
        return last.y.copy()

    def _steps(self, touched: Bools) -> list[_Step]:
        """Return the steps that eliminate the pivots of the boxes that are `touched`."""
        found = []
        for fronts, halves, boxes in self._up(np.flatnonzero(touched)):
            if 2 * len(boxes) > fronts.count:
                boxes = np.arange(fronts.count)  # all of them cost less than copies of most
            where = stretch(boxes)
            taken = [
                (half.number, stretch(boxes + chosen.start), places)
                for half, (_, chosen, _), places in zip(halves, fronts.group.halves, fronts.from_halves, strict=True)
            ]
            carry = fronts.carry[where].transpose(0, 2, 1)
            found.append(_Step(fronts, where, fronts.nodes[where, : fronts.pivots], fronts.factor[where], carry, taken))
        return found

    def _eliminate(self, b: Floats, taken: Taken, steps: list[_Step]) -> Iterator[tuple[_Step, Floats]]:
        """Take the steps of a first half for b (N, k); yield what each makes of its pivots (n, p, k)."""
        for step in steps:
            fronts, p = step.fronts, step.fronts.pivots
            parts = [
                taken[number][boxes].take(places, axis=1) for number, boxes, places in step.halves if number in taken
            ]
            own = b.take(step.nodes, axis=0)
            for part in parts:
                own -= part[:, :p]
            done = solve_lower(step.factor, own)
            yield step, done
            around = step.carry @ (own if fronts.is_leaf else done)
            for part in parts:
                around += part[:, p:]
            if fronts.number not in taken:
                taken[fronts.number] = np.zeros((fronts.count, fronts.size - p + 1, b.shape[1]))
            taken[fronts.number][step.where, :-1] = around

    def backward(self, y: Floats) -> Floats:
        """Return Pᵀ L⁻ᵀ y, the second half (FAT eq. 13): backward(forward(b)) = A⁻¹ b."""
        x = np.zeros((self._inner + 1, y.shape[1]))
        for fronts in self._fronts:
            shape = fronts.count, fronts.pivots, y.shape[1]
            left, found = y[fronts.own].reshape(shape), x[fronts.own].reshape(shape)
            known = fronts.carry @ x.take(fronts.around, axis=0)
            if not fronts.is_leaf:
                found[...] = solve_upper(fronts.factor, left - known)
                continue
            np.negative(known, out=found)
            loaded = np.flatnonzero(left.any(axis=(1, 2)))
            if loaded.size:
                where = stretch(loaded)
                found[where] += solve_upper(fronts.factor[where], left[where])
        return x.take(self._place, axis=0)

    def place(self, y: Floats, onto: Onto) -> tuple[Complexes, None]:
        """Return where `backward` takes all nodes (R, C); what that folds is not known."""
        return onto.moved(np.ascontiguousarray(self.backward(y)).view(np.complex128)[:, 0]), None

    def __repr__(self) -> str:
        return f"GridFactor({self.size} unknowns, {len(self._whole)} boxes)"
