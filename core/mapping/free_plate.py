"""How a grid that nothing holds answers forces: the energy of `editing`, factorised once per grid.

A response is a substitution: a column of A⁻¹ Cᵀ, with C the bilinear weights of the places. While there are few of
them they are kept, and d is a sum of columns; while there are many, d costs a substitution.
"""

import numpy as np
from scipy import sparse

from core.arrays import Points
from core.factor import Factor
from core.grid import Grid
from core.mapping.frames import Complexes
from core.mapping.held_plate import known_responses

_RIDGE = 1e-7
"""Makes A definite; similarities, which it would hold back, are added to d outside."""
_SOLVED_AT_ONCE = 200_000
"""Numbers in the columns that one substitution gives: it keeps the interpreter lock, some hundredths of a second."""
_KEPT_AT_MOST = 4_000_000
"""Numbers in the columns that are kept: more would take more memory than a substitution takes time."""


class FreePlate:
    """Responses of a grid to forces at any places of the picture, but for similarities of the whole.

    Parameters
    ----------
    cell
        Width and height of a cell in units of their mean.
    rounded
        ℓ in cells.
    """

    def __init__(self, grid: Grid, *, cell: tuple[float, float], rounded: float) -> None:
        self._grid = grid
        A = _opposite_part(grid, cell) + rounded**2 * _bending(grid, cell)
        self._factor = Factor(A + _RIDGE * sparse.eye_array(grid.size))
        self._points: Points = np.empty((0, 2))
        self._weights = sparse.csr_array((0, grid.size))
        self._S: Complexes = np.empty((0, 0), np.complex128)
        self._columns: Complexes | None = np.empty((0, grid.size), np.complex128)
        """A⁻¹ Cᵀ, a row per place; None where it is not kept."""

    def hold(self, points: Points) -> Complexes:
        """Declare the places (n, 2) of the forces and return S (n, n): what a force at one moves another."""
        before, S = known_responses(points, self._points, self._S)
        old = np.flatnonzero(before >= 0)
        columns = None
        if len(points) * self._grid.size <= _KEPT_AT_MOST and (self._columns is not None or not old.size):
            columns = np.empty((len(points), self._grid.size), np.complex128)
            if self._columns is not None:
                columns[old] = self._columns[before[old]]
        C = self._weights_at(points)
        new = np.flatnonzero(before < 0)
        at_once = max(_SOLVED_AT_ONCE // self._grid.size, 1)
        for start in range(0, len(new), at_once):
            some = new[start : start + at_once]
            found = self._factor.solve(C[some].toarray().T)
            S[:, some] = C @ found
            S[some, :] = S[:, some].conj().T
            if columns is not None:
                columns[some] = found.T
        self._points, self._weights, self._S, self._columns = points.copy(), C, S, columns
        return S

    def answer(self, forces: Complexes) -> Complexes:
        """Return d (N,) for the forces (n,) at the places."""
        if self._columns is not None:
            return np.asarray(self._columns.T @ forces)
        return self._factor.solve(np.asarray(self._weights.T @ forces))

    def _weights_at(self, points: Points) -> sparse.csr_array:
        """Return C (n, N)."""
        nodes, weights = self._grid.weights_at(points)
        return sparse.csr_array(
            (weights.ravel(), nodes.ravel(), np.arange(0, nodes.size + 1, 4)), shape=(len(points), self._grid.size)
        )


def _steps(count: int, cell: float) -> sparse.csr_array:
    """Return first differences over `count` nodes, per unit length."""
    return sparse.csr_array(sparse.diags_array([-1 / cell, 1 / cell], offsets=[0, 1], shape=(count - 1, count)))


def _means(count: int) -> sparse.csr_array:
    return sparse.csr_array(sparse.diags_array([0.5, 0.5], offsets=[0, 1], shape=(count - 1, count)))


def _opposite_part(grid: Grid, cell: tuple[float, float]) -> sparse.csr_array:
    """Return the matrix of Σ |d_x + i d_y|², which vanishes for similarities."""
    across = sparse.kron(_means(grid.rows), _steps(grid.columns, cell[0]))
    down = sparse.kron(_steps(grid.rows, cell[1]), _means(grid.columns))
    total = sparse.csr_array(across + 1j * down)
    return sparse.csr_array(total.conj().T @ total)


def _bending(grid: Grid, cell: tuple[float, float]) -> sparse.csr_array:
    """Return the matrix of Σ |d_xx|² + 2 |d_xy|² + |d_yy|², which vanishes for affine maps."""
    x, y = _steps(grid.columns, cell[0]), _steps(grid.rows, cell[1])
    rows, columns = sparse.eye_array(grid.rows), sparse.eye_array(grid.columns)
    parts = [np.sqrt(2) * sparse.kron(y, x)]
    if grid.columns > 2:
        parts.append(sparse.kron(rows, _steps(grid.columns - 1, cell[0]) @ x))
    if grid.rows > 2:
        parts.append(sparse.kron(_steps(grid.rows - 1, cell[1]) @ y, columns))
    return sparse.csr_array(sum(part.T @ part for part in parts))
