"""The Cholesky factor of a five-point system on a grid, renewed only where the system changes  [FAT eqs. 11-13].

Boxes of the nested dissection are eliminated from the smallest up. An entry of the matrix belongs to one box; where
entries change, that box and all that hold it are eliminated again, and no other. The same goes for the first half of a
solve. Under a brush that is little: a way from a few small boxes up to the whole.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from core.arrays import Bools, Floats, Ints, SingularSystemError
from core.linalg.cubic_convolution import Complexes
from core.linalg.dissection import Group, dissect
from core.linalg.fronts import Fronts, stretch
from core.linalg.grid_solver import Onto
from core.tracing import span

_ALL_KEPT_AT_MOST = 300_000
"""Nodes of a grid up to which what boxes leave is kept from a tile on."""
_LEAST_KEPT = 16
"""Tiles from which on it is kept on larger grids, where it takes much memory."""
_BOXES_AT_ONCE = 2000
"""About so many boxes are eliminated before those that hold them all: what they leave stays in the memory at hand."""


@dataclass(frozen=True, eq=False)
class _Half:
    """The first half of a solve."""

    b: Floats
    y: Floats
    taken: dict[int, Floats]
    """What boxes take off the load on their frames, and a 0, by the number of their group; where there is any."""


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
        return self.backward(self.forward(b))

    def forward(self, b: Floats, nodes: Ints | None = None, asked: Ints | None = None) -> Floats:
        """Return L⁻¹ P b, the first half of a solve (FAT eq. 12): forward(a)ᵀ forward(b) = aᵀ A⁻¹ b.

        `nodes` are those where b is not 0, by default all.
        """
        homes = np.arange(len(self._whole)) if nodes is None else self._home[3 * nodes]
        half = _Half(b, np.zeros((self._inner, b.shape[1])), {})
        self._eliminate(half, self._with_wholes(homes))
        return half.y

    def forward_again(self, values: Floats, nodes: Ints) -> Floats:
        """Return forward(b), b with `values` (m, k) at `nodes` and else 0: only what is not as in the last call."""
        b = np.zeros((self.size, values.shape[1]))
        b[nodes] = values
        last, self._last = self._last, None
        if last is None or last.b.shape != b.shape:
            last = _Half(np.zeros(b.shape), np.zeros((self._inner, b.shape[1])), {})
        changed = np.flatnonzero(b != last.b) // b.shape[1]
        half = _Half(b, last.y, last.taken)
        self._eliminate(half, self._with_wholes(self._home[3 * changed]) | self._renewed)
        self._renewed[:] = False
        self._last = half
        return half.y.copy()

    def _eliminate(self, half: _Half, touched: Bools) -> None:
        """Eliminate the pivots of the boxes that are `touched`."""
        k = half.b.shape[1]
        for fronts, halves, boxes in self._up(np.flatnonzero(touched)):
            if 2 * len(boxes) > fronts.count:
                boxes = np.arange(fronts.count)  # all of them cost less than copies of most
            p, where = fronts.pivots, stretch(boxes)
            taken = [
                half.taken[part.number][stretch(boxes + chosen.start)].take(places, axis=1)
                for part, (_, chosen, _), places in zip(halves, fronts.group.halves, fronts.from_halves, strict=True)
                if part.number in half.taken
            ]
            own = half.b.take(fronts.nodes[where, :p], axis=0)
            for part in taken:
                own -= part[:, :p]
            done = fronts.inverse[where] @ own
            half.y[fronts.own].reshape(fronts.count, p, k)[where] = done
            around = fronts.Y[where].transpose(0, 2, 1) @ done
            for part in taken:
                around += part[:, p:]
            if fronts.number not in half.taken:
                half.taken[fronts.number] = np.zeros((fronts.count, fronts.size - p + 1, k))
            half.taken[fronts.number][where, :-1] = around

    def backward(self, y: Floats) -> Floats:
        """Return Pᵀ L⁻ᵀ y, the second half (FAT eq. 13): backward(forward(b)) = A⁻¹ b."""
        x = np.zeros((self._inner + 1, y.shape[1]))
        for fronts in self._fronts:
            shape = fronts.count, fronts.pivots, y.shape[1]
            known = y[fronts.own].reshape(shape) - fronts.Y @ x.take(fronts.around, axis=0)
            np.matmul(fronts.inverse.transpose(0, 2, 1), known, out=x[fronts.own].reshape(shape))
        return x.take(self._place, axis=0)

    def place(self, y: Floats, onto: Onto) -> tuple[Complexes, None]:
        """Return where `backward` takes all nodes (R, C); what that folds is not known."""
        return onto.moved(self.backward(y)), None

    def __repr__(self) -> str:
        return f"GridFactor({self.size} unknowns, {len(self._whole)} boxes)"
