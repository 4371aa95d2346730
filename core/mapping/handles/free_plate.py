"""How a grid that nothing holds answers forces: the energy of `plate` with its frame free.

What handles do is smooth over a tenth of the picture, so that it is worked out on a grid of a few thousand nodes, whose
matrix A is factorised once, and interpolated by cubics: d = U A⁻¹ (C U)ᵀ forces, with C the bilinear weights of the
places on the fine grid. So what the places are to do they do exactly. A response is a substitution: a column of
A⁻¹ (C U)ᵀ.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from core.arrays import Floats, Points
from core.grid import Grid
from core.linalg.cubic_convolution import CubicConvolution
from core.linalg.factor import Factor
from core.mapping.jacobians import Complexes
from core.mapping.tolerances import TIE

SMOOTH_NODES = 2500
"""Nodes of a grid on which smooth things are worked out, about: an answer takes some tenths of a millisecond."""


class FreePlate:
    """Responses of a grid to forces at any places of the picture, but for similarities of the whole.

    Parameters
    ----------
    smoothness
        ℓ as a share of the grid's diagonal.
    """

    def __init__(self, grid: Grid, *, smoothness: float) -> None:
        self.grid = grid
        self._coarse = grid.with_nodes(SMOOTH_NODES)
        self._cubic = CubicConvolution(self._coarse.shape, grid.shape)
        cell = self._coarse.cell_aspect
        rounded = smoothness * float(np.hypot(*self._coarse.shape))
        A = _opposite_part(self._coarse, cell) + rounded**2 * _bending(self._coarse, cell)
        # The tie makes A definite; similarities, which it would hold back, are added to d outside.
        self._factor = Factor(A + TIE * scipy.sparse.eye_array(self._coarse.size))

    def hold(self, points: Points, known: "FreeForces | None" = None) -> "FreeForces":
        """Return how it answers forces at the points (n, 2); what is `known` of some of them is not worked out anew."""
        columns = np.empty((len(points), self._coarse.size), np.complex128)
        S = np.zeros((len(points), len(points)), np.complex128)
        before = np.full(len(points), -1)
        if known is not None:
            number = {tuple(point): i for i, point in enumerate(known.points.tolist())}
            before = np.array([number.get(tuple(point), -1) for point in points.tolist()], np.int64)
        old, new = np.flatnonzero(before >= 0), np.flatnonzero(before < 0)
        if known is not None:
            columns[old] = known.columns[before[old]]
            S[np.ix_(old, old)] = known.S[np.ix_(before[old], before[old])]
        if new.size:
            weights = self._weights_at(points)
            columns[new] = self._factor.solve(weights[new].T.astype(np.complex128)).T
            S[:, new] = weights @ columns[new].T
            S[new, :] = S[:, new].conj().T
        return FreeForces(S, points, columns, self)

    def refine(self, d: Complexes) -> Complexes:
        """Return what is d at the nodes of the coarse grid at those of the fine one (N,)."""
        return self._cubic.refine(d.reshape(self._coarse.shape)).ravel()

    def _weights_at(self, points: Points) -> Floats:
        """Return C U (n, nodes of the coarse grid)."""
        found = []
        for axis, matrix in ((1, self._cubic.down), (0, self._cubic.across)):
            place = (points[:, axis] + 0.5) / self.grid.cell[axis]
            cell = np.clip(place.astype(np.int64), 0, matrix.shape[0] - 2)
            share = (place - cell)[:, None]
            found.append((1 - share) * matrix[cell].toarray() + share * matrix[cell + 1].toarray())
        return np.asarray((found[0][:, :, None] * found[1][:, None, :]).reshape(len(points), -1))


@dataclass(frozen=True, eq=False)
class FreeForces:
    """Answers to forces at some points."""

    S: Complexes
    """What a force at one moves another (n, n)."""
    points: Points
    columns: Complexes
    """A⁻¹ (C U)ᵀ, a row per point."""
    plate: FreePlate

    def answer(self, forces: Complexes) -> Complexes:
        """Return d (N,) for the forces (n,)."""
        return self.plate.refine(self.columns.T @ forces)


def _steps(count: int, cell: float) -> "scipy.sparse.csr_array":
    """Return first differences over `count` nodes, per unit length."""
    return scipy.sparse.csr_array(
        scipy.sparse.diags_array([-1 / cell, 1 / cell], offsets=[0, 1], shape=(count - 1, count))
    )


def _means(count: int) -> "scipy.sparse.csr_array":
    return scipy.sparse.csr_array(scipy.sparse.diags_array([0.5, 0.5], offsets=[0, 1], shape=(count - 1, count)))


def _opposite_part(grid: Grid, cell: tuple[float, float]) -> "scipy.sparse.csr_array":
    """Return the matrix of Σ |d_x + i d_y|², which vanishes for similarities."""
    across = scipy.sparse.kron(_means(grid.rows), _steps(grid.columns, cell[0]))
    down = scipy.sparse.kron(_steps(grid.rows, cell[1]), _means(grid.columns))
    total = scipy.sparse.csr_array(across + 1j * down)
    return scipy.sparse.csr_array(total.conj().T @ total)


def _bending(grid: Grid, cell: tuple[float, float]) -> "scipy.sparse.csr_array":
    """Return the matrix of Σ |d_xx|² + 2 |d_xy|² + |d_yy|², which vanishes for affine maps."""
    x, y = _steps(grid.columns, cell[0]), _steps(grid.rows, cell[1])
    rows, columns = scipy.sparse.eye_array(grid.rows), scipy.sparse.eye_array(grid.columns)
    parts = [np.sqrt(2) * scipy.sparse.kron(y, x)]
    if grid.columns > 2:
        parts.append(scipy.sparse.kron(rows, _steps(grid.columns - 1, cell[0]) @ x))
    if grid.rows > 2:
        parts.append(scipy.sparse.kron(_steps(grid.rows - 1, cell[1]) @ y, columns))
    return scipy.sparse.csr_array(sum(part.T @ part for part in parts))
