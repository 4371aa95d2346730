"""Deform a grid by handles: the Laplacian editing of the interactive mode  [FAT sec. 3, eq. 8].

The deformation is base + d. With z = x + iy in cells, the displacement d minimises

    E(d) = Σ |∂d|² + ℓ² Σ (|d_xx|² + 2 |d_xy|² + |d_yy|²)      so that d = c - base at every handle.

With the frame held, d = 0 on the outline and ∂ is the gradient. With the frame free, ∂ is the part of the derivative
that is no similarity (d/d conj z); E is then zero for similarities and for nothing else. Either way, handles that all
agree with one similarity of the base give that similarity. The second term is what keeps handles from drawing the
picture into spikes; ℓ is the distance over which they are rounded.

The matrix A of E is factorised once per grid. With C the bilinear weights of the handles, d = A⁻¹ Cᵀ λ + Q m where
S = C A⁻¹ Cᵀ is as small as the number of handles, and Q spans the similarities (frame free; Qᵀ Cᵀ λ = 0) or nothing
(frame held). A new handle costs one solve, for its column of A⁻¹ Cᵀ and of S. While there are few handles their columns
are kept, and d is a sum of columns; while there are many, d costs a solve.
"""

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from core.arrays import InputError, Points
from core.factor import Factor
from core.grid import Grid
from core.mapping.exact import as_one, as_two
from core.mapping.frames import Complexes, as_complex, as_positions
from core.mapping.handles import Handles
from core.tracing import span

Frame = Literal["held", "free"]

_RIDGE = 1e-7
"""Makes A definite where the frame is free; Q carries what it would hold back."""
_REFINEMENTS = 3
_EXACT = 1e-12
_TOGETHER = 1e-12
"""Handles whose responses differ by no more than this share are taken as one."""
_KEPT_AT_MOST = 4_000_000
"""Numbers in the columns that are kept: more would take more memory than a solve takes time."""


class Editing:
    """Deform a grid by handles at any places of the picture; factor once per grid, solve once per frame.

    Parameters
    ----------
    frame
        "held": the outline stays where the base has it; "free": nothing but the handles holds the picture.
    smoothness
        ℓ as a share of the grid's diagonal.
    """

    def __init__(self, grid: Grid, *, frame: Frame = "held", smoothness: float = 0.1) -> None:
        if not smoothness > 0:
            raise InputError(f"smoothness of {smoothness:g}: must be positive")
        self.grid, self.frame = grid, frame
        self._length = float(np.hypot(grid.width_px, grid.height_px))
        rounded = smoothness * float(np.hypot(*grid.shape))
        self._free = np.flatnonzero(~grid.outline) if frame == "held" else np.arange(grid.size)
        first = _gradient(grid) if frame == "held" else _opposite_part(grid)
        A = sparse.csc_array(first + rounded**2 * _bending(grid))[self._free][:, self._free]
        if frame == "free":
            A = A + _RIDGE * sparse.eye_array(grid.size)
        self._factor = Factor(A) if self._free.size else None
        self._scalar: Any = np.float64 if frame == "held" else np.complex128
        self._points = np.empty((0, 2))
        self._weights = sparse.csr_array((0, grid.size))
        self._S: NDArray[Any] = np.empty((0, 0), self._scalar)
        self._columns: NDArray[Any] | None = np.empty((0, self._free.size), self._scalar)
        """A⁻¹ Cᵀ, a row per handle; None where it is not kept."""
        self._inverse: NDArray[Any] = np.empty((0, 0))

    def hold(self, points: Points) -> None:
        """Declare the places (n, 2) of the handles, in pixels of the picture; those declared before cost nothing.

        With the frame held, a place within a cell of it, or outside the picture, stands for the closest one a cell
        inside: what lies on the frame no handle can move.
        """
        points = np.asarray(points, np.float64).reshape(-1, 2)
        if self._factor is None or np.array_equal(points, self._points):
            return
        with span("handles", count=len(points)):
            weights = self._weights_at(self._inside(points))
            self._S, self._columns = self._responses(points, weights)
            self._points, self._weights = points.copy(), weights
            system = np.block([[self._S, self._similar()], [self._similar().conj().T, np.zeros((self._spare,) * 2)]])
            self._inverse = np.linalg.pinv(system, rcond=_TOGETHER, hermitian=True)

    def solve(self, targets: Points, base: Points | None = None) -> Points:
        """Return where the nodes (R, C, 2) go so that the handles reach `targets` (n, 2).

        `base` (R, C, 2) is where they go without handles, by default where they are; its outline is the frame.
        """
        start = as_complex(self.grid.nodes if base is None else base)
        if self._factor is None or not len(self._points):
            return as_positions(start.copy())
        with span("editing"):
            goal = as_complex(np.asarray(targets, np.float64)) - _times(self._weights_at(self._points), start.ravel())
            d = np.zeros(self.grid.size, np.complex128)
            for _ in range(_REFINEMENTS):
                d += self._displacement(goal - _times(self._weights, d))
                if np.abs(goal - _times(self._weights, d)).max() < _EXACT * np.abs(goal).max():
                    break
        return as_positions(start + d.reshape(start.shape))

    def _displacement(self, goal: Complexes) -> Complexes:
        """Return the nodes' d (N,) for the handles' d (n,)."""
        assert self._factor is not None
        found = self._inverse @ np.concatenate([goal, np.zeros(self._spare)])
        d = np.zeros(self.grid.size, np.complex128)
        d[self._free] = self._answer(found[: len(goal)])
        if self.frame == "held":
            return d
        p = as_complex(self.grid.nodes).ravel() / self._length
        d += found[-1]
        return d + p * found[-2] if self._spare > 1 else d

    def _answer(self, forces: Complexes) -> Complexes:
        """Return A⁻¹ Cᵀ λ on the free nodes for the handles' λ (n,)."""
        assert self._factor is not None
        if self._columns is not None:
            held = self.frame == "held"
            return as_one(self._columns.T @ as_two(forces)) if held else np.asarray(self._columns.T @ forces)
        load = np.asarray(self._weights.T @ forces)[self._free]
        return as_one(self._factor.solve(as_two(load))) if self.frame == "held" else self._factor.solve(load)

    @property
    def _spare(self) -> int:
        """Columns of Q: one handle alone moves the picture, two turn and scale it too."""
        return 0 if self.frame == "held" else min(len(self._points), 2)

    def _similar(self) -> Complexes:
        """Return C Q."""
        here = as_complex(self._points)[:, None] / self._length
        return np.concatenate([here, np.ones_like(here)], axis=1)[:, 2 - self._spare :]

    def _inside(self, points: Points) -> Points:
        if self.frame == "free":
            return points
        margin = np.minimum(self.grid.cell, np.array([self.grid.width_px, self.grid.height_px]) / 2)
        return np.clip(points, margin - 0.5, [self.grid.width_px, self.grid.height_px] - margin - 0.5)

    def _weights_at(self, points: Points) -> sparse.csr_array:
        """Return C (n, N)."""
        nodes, weights = self.grid.weights_at(points)
        return sparse.csr_array(
            (weights.ravel(), nodes.ravel(), np.arange(0, nodes.size + 1, 4)), shape=(len(points), self.grid.size)
        )

    def _responses(self, points: Points, weights: sparse.csr_array) -> tuple[NDArray[Any], NDArray[Any] | None]:
        """Return S and A⁻¹ Cᵀ, in which what belongs to places known before is kept."""
        assert self._factor is not None
        known = {tuple(point): i for i, point in enumerate(self._points.tolist())}
        before = np.array([known.get(tuple(point), -1) for point in points.tolist()], np.int64)
        old = np.flatnonzero(before >= 0)
        S = np.zeros((len(points), len(points)), self._scalar)
        S[np.ix_(old, old)] = self._S[np.ix_(before[old], before[old])]
        columns = None
        if len(points) * self._free.size <= _KEPT_AT_MOST and (self._columns is not None or not old.size):
            columns = np.empty((len(points), self._free.size), self._scalar)
            if self._columns is not None:
                columns[old] = self._columns[before[old]]
        C = sparse.csr_array(weights[:, self._free])
        for j in np.flatnonzero(before < 0):
            column = self._factor.solve(C[[j]].toarray()[0])
            S[:, j] = C @ column
            S[j, :] = S[:, j].conj()
            if columns is not None:
                columns[j] = column
        return S, columns


def _times(matrix: sparse.csr_array, z: Complexes) -> Complexes:
    return np.asarray(matrix @ z, np.complex128)


def _steps(count: int, cell: float) -> sparse.csr_array:
    """Return first differences over `count` nodes, per unit length."""
    return sparse.csr_array(sparse.diags_array([-1 / cell, 1 / cell], offsets=[0, 1], shape=(count - 1, count)))


def _means(count: int) -> sparse.csr_array:
    return sparse.csr_array(sparse.diags_array([0.5, 0.5], offsets=[0, 1], shape=(count - 1, count)))


def _axes(grid: Grid) -> tuple[float, float]:
    """Return width and height of a cell in units of their mean."""
    width, height = grid.cell
    unit = float(np.sqrt(width * height))
    return width / unit, height / unit


def _gradient(grid: Grid) -> sparse.csr_array:
    """Return the matrix of Σ |d_x|² + |d_y|²."""
    width, height = _axes(grid)
    across = sparse.kron(sparse.eye_array(grid.rows), _steps(grid.columns, width))
    down = sparse.kron(_steps(grid.rows, height), sparse.eye_array(grid.columns))
    return sparse.csr_array(across.T @ across + down.T @ down)


def _opposite_part(grid: Grid) -> sparse.csr_array:
    """Return the matrix of Σ |d_x + i d_y|², which vanishes for similarities."""
    width, height = _axes(grid)
    across = sparse.kron(_means(grid.rows), _steps(grid.columns, width))
    down = sparse.kron(_steps(grid.rows, height), _means(grid.columns))
    total = sparse.csr_array(across + 1j * down)
    return sparse.csr_array(total.conj().T @ total)


def _bending(grid: Grid) -> sparse.csr_array:
    """Return the matrix of Σ |d_xx|² + 2 |d_xy|² + |d_yy|², which vanishes for affine maps."""
    width, height = _axes(grid)
    x, y = _steps(grid.columns, width), _steps(grid.rows, height)
    rows, columns = sparse.eye_array(grid.rows), sparse.eye_array(grid.columns)
    parts = [np.sqrt(2) * sparse.kron(y, x)]
    if grid.columns > 2:
        parts.append(sparse.kron(rows, _steps(grid.columns - 1, width) @ x))
    if grid.rows > 2:
        parts.append(sparse.kron(_steps(grid.rows - 1, height) @ y, columns))
    return sparse.csr_array(sum(part.T @ part for part in parts))


def edit_grid(grid: Grid, handles: Handles, *, base: Points | None = None, frame: Frame = "held") -> Points:
    """Return where the nodes (R, C, 2) go so that the handles reach their targets: one-off form of `Editing`."""
    editing = Editing(grid, frame=frame)
    at, to = handles.points(grid)
    editing.hold(at)
    return editing.solve(to, base)
