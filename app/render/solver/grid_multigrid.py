"""Multigrid in the place of a grid's Cholesky factor: `core.linalg.grid_solver.GridSolver` on the GPU.

There is no half of a solve here: loads stay what they are, and their product is aᵀ A⁻¹ b. Features and handles are
reduced to their few unknowns by these products, as by those of the factor. A⁻¹ is symmetric: products of a few columns
with any load are products with what the columns lead to, which is kept; those of many cost a solve for that load.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import moderngl
import numpy as np
from scipy import sparse

from app.render.gpu import release
from app.render.solver.multigrid import Multigrid
from app.render.solver.node_placement import NodePlacement
from core.arrays import Bools, Floats, Ints, Singles
from core.linalg.cubic_convolution import Complexes
from core.linalg.grid_solver import Onto
from core.linalg.laplacian import find_stored, pattern

_WITHIN_PX = 1e-3
"""How far solutions may be off in output pixels, before those that features and handles are placed by are improved."""
_SHARE = 1e-4
"""The same of what improves a solution, as a share of its largest value."""
_KEPT = 16
"""Columns of which A⁻¹ b is kept at all nodes, where nobody says which of them loads will be at: of so many handles."""


class GridMultigrid:
    """Solves A x = b on a grid, from the last solution of the same kind on.

    Raises `moderngl.Error` where the context lacks OpenGL 4.3.
    """

    def __init__(self, context: moderngl.Context, shape: tuple[int, int]) -> None:
        self._shape, self.size = shape, shape[0] * shape[1]
        self._multigrid = Multigrid(context, shape)
        self._placement = NodePlacement(context, self._multigrid.hierarchy)
        self._shown, self._read = self._multigrid.solution(), self._multigrid.solution()
        """The last ones of what is shown, and of what features and handles are placed by."""
        self._kept = self._multigrid.solution()

    @property
    def steps(self) -> int:
        """Steps of conjugate gradients so far."""
        return self._multigrid.steps

    def factorise(self, values: Floats) -> "GridMultigrid":
        """Take new values (R, C, 3) of `laplacian.node_values`; return the solver itself."""
        self._multigrid.hierarchy.take(values)
        lower = pattern(self._shape)
        lower.data = values[find_stored(self._shape)]
        self._matrix = sparse.csr_array(lower + sparse.tril(lower, -1).T)
        return self

    def solve(self, b: Floats) -> Floats:
        """Solve A x = b for b (N, 2)."""
        return self._solve(b, self._shown)

    def forward(self, b: Floats, nodes: Ints | None = None, asked: Ints | None = None) -> "Loads":
        """Return loads b (N, k), which are 0 but at `nodes`, for products with others at nodes that will be `asked`."""
        rows = np.unique(nodes) if nodes is not None else np.flatnonzero(b.any(axis=1))
        return Loads(self, rows, b[rows], asked)

    def forward_again(self, values: Floats, nodes: Ints) -> "NodeLoad":
        """Return the load that has `values` (m, 2) at `nodes`, ascending."""
        return NodeLoad(self.size, ((nodes, values),) if nodes.size else ())

    def place(self, y: "NodeLoad", onto: Onto) -> tuple[Complexes, Bools]:
        """Return where A⁻¹ y takes all nodes (R, C), and which quads that folds."""
        self._multigrid.load.clear()
        for nodes, values in y.parts:
            self._placement.add(self._multigrid.load, nodes, values)
        self._multigrid.solve(None, self._shown, within=_WITHIN_PX)
        return self._placement.place(self._shown, onto)

    def read(self, y: Floats, rows: Ints) -> Floats:
        """Return A⁻¹ y at some rows (m, 2)."""
        return self._improved(self._solve(y, self._read), y)[rows]

    def respond(self, loads: "Loads") -> Iterator[Floats]:
        """Yield A⁻¹ b (N, 2) for two columns after the other; the last of an odd number has a column of 0 beside."""
        for first in range(0, loads.count, 2):
            pair = np.zeros((self.size, 2))
            chosen = loads.at_rows[:, first : first + 2]
            pair[loads.rows, : chosen.shape[1]] = chosen
            yield self._improved(self._improved(np.zeros_like(pair), pair), pair)

    def _solve(self, load: Floats, v: moderngl.Buffer) -> Floats:
        self._multigrid.solve(load, v, within=_WITHIN_PX)
        return _numbers(v)

    def _improved(self, found: Floats, load: Floats) -> Floats:
        """Return A⁻¹ b (N, 2) with more digits than a solution that was found has, by solving for what that leaves."""
        self._kept.clear()
        self._multigrid.solve(load - self._matrix @ found, self._kept, within=_SHARE, share=True)
        return found + _numbers(self._kept)

    def release(self) -> None:
        """Free the GPU objects."""
        release(self._multigrid, self._placement, self._kept, self._shown, self._read)


@dataclass(frozen=True, eq=False)
class NodeLoad:
    """A load (N, 2), the sum of some that are 0 but at a few nodes."""

    size: int
    parts: tuple[tuple[Ints, Floats], ...]
    """Nodes, ascending, and what is there (m, 2)."""

    def __add__(self, other: "NodeLoad") -> "NodeLoad":
        return NodeLoad(self.size, self.parts + other.parts)

    @property
    def whole(self) -> Floats:
        """The load of all nodes (N, 2)."""
        found = np.zeros((self.size, 2))
        for nodes, values in self.parts:
            found[nodes] += values
        return found


class Loads:
    """Columns of loads (N, k), 0 but at some rows; products with them are solves.

    What a load has in common with them is taken out of it before, so that little is left to lose digits: with s the
    shares of the columns that come closest to y, bᵀ A⁻¹ y = (bᵀ A⁻¹ b) s + bᵀ A⁻¹ (y - b s).
    """

    def __init__(self, solver: GridMultigrid, rows: Ints, at_rows: Floats, asked: Ints | None = None) -> None:
        self._solver, self.rows, self.at_rows = solver, rows, at_rows
        self._asked = np.arange(solver.size) if self.count <= _KEPT else rows
        """Where responses are kept, ascending."""
        if asked is not None:
            self._asked = np.union1d(asked, rows)
        self._known: dict[int, tuple[Ints, Ints, Floats | None]] = {}
        """Of nodes that loads were at."""

    @property
    def T(self) -> "_Transposed":  # noqa: N802
        """What multiplies others from the left."""
        return _Transposed(self)

    def __matmul__(self, shares: Floats) -> NodeLoad:
        return NodeLoad(self._solver.size, ((self.rows, self.at_rows @ shares),))

    def __getitem__(self, columns: Any) -> "Loads":
        return Loads(self._solver, self.rows, self.at_rows[columns])

    @property
    def count(self) -> int:
        """How many columns there are."""
        return int(self.at_rows.shape[1])

    def respond_to(self, other: "Loads") -> Floats:
        """Return A⁻¹ times other loads, at the rows of these (m, k)."""
        found = [both[self.rows] for both in self._solver.respond(other)]
        return np.concatenate(found, axis=1)[:, : other.count] if found else np.zeros((len(self.rows), 0))

    @cached_property
    def _closest(self) -> Floats:
        """What takes a load at the rows to the shares of the columns that come closest to it (k, m)."""
        return np.asarray(np.linalg.pinv(self.at_rows), np.float64)

    @cached_property
    def _responses(self) -> tuple[Floats, Singles]:
        """A⁻¹ b at the rows (m, k), and where it is kept (n, k)."""
        at_rows = np.zeros((len(self.rows), self.count))
        kept = np.zeros((len(self._asked), self.count), np.float32)
        for number, both in enumerate(self._solver.respond(self)):
            here = slice(2 * number, min(2 * number + 2, self.count))
            both = both[:, : here.stop - here.start]
            at_rows[:, here] = both[self.rows]
            kept[:, here] = both[self._asked]
        return at_rows, kept

    @cached_property
    def products(self) -> Floats:
        """Evaluate bᵀ A⁻¹ b (k, k)."""
        products = self.at_rows.T @ self._responses[0]
        return np.asarray((products + products.T) / 2)

    @cached_property
    def _rounding(self) -> Floats:
        """What single precision takes of the products (k, k)."""
        kept = self._responses[1][np.searchsorted(self._asked, self.rows)]
        return np.asarray(self.products - kept.T @ self.at_rows)

    def times(self, y: NodeLoad) -> Floats:
        """Return bᵀ A⁻¹ y (k, 2)."""
        at_rows, found = np.zeros((len(self.rows), 2)), []
        for nodes, values in y.parts:
            place, responses = self._read_at(nodes)
            at_rows += np.where((nodes[place] == self.rows)[:, None], values[place], 0)
            if responses is not None:
                found.append(responses @ values)
        shares = self._closest @ at_rows
        if len(found) == len(y.parts):
            return np.asarray(sum(found, self._rounding @ shares))
        rest = (y + self @ -shares).whole
        return np.asarray(self.products @ shares + self.at_rows.T @ self._solver.read(rest, self.rows))

    def _read_at(self, nodes: Ints) -> tuple[Ints, Floats | None]:
        """Return which of the `nodes` are the rows, others where they are not, and responses there (k, n), if kept."""
        if id(nodes) not in self._known:
            place = np.searchsorted(nodes, self.rows).clip(max=len(nodes) - 1)
            kept = np.searchsorted(self._asked, nodes).clip(max=len(self._asked) - 1)
            responses = self._responses[1][kept].T.astype(np.float64) if (self._asked[kept] == nodes).all() else None
            self._known[id(nodes)] = nodes, place, responses
        return self._known[id(nodes)][1:]


class _Transposed:
    """Loads that multiply from the left."""

    def __init__(self, loads: Loads) -> None:
        self._loads = loads

    def __matmul__(self, other: NodeLoad | Loads) -> Floats:
        loads = self._loads
        if other is loads:
            return loads.products
        if isinstance(other, Loads):
            return loads.at_rows.T @ loads.respond_to(other)
        return loads.times(other)


def _numbers(v: moderngl.Buffer) -> Floats:
    """Return a solution (N, 2)."""
    return np.frombuffer(v.read(), np.float32).reshape(-1, 2).astype(np.float64)
