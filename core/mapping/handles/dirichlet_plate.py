"""How a grid with its outline held answers forces: the energy of `editing`, which sines make diagonal.

With d = 0 on the outline, the first differences of a row make up the matrix T of the second difference with Dirichlet
ends, and its second differences make up T²; so do those of a column. Both are diagonal in the sines

    s_k(x) = √(2 / n) sin(π k x / n),  k = 1 … n - 1,      T s_k = t_k s_k,  t_k = (2 - 2 cos(π k / n)) / width²

over the n cells of a row. So A = L + ℓ² L² with L = T_x + T_y, and it is a_kl = t + ℓ² t² with t = t_k + t_l on
s_k(x) s_l(y). Nothing is factorised: d is a sum of sines along rows and columns.

A product of two sines is half a difference of cosines, so what a force on one node does to another is

    A⁻¹(p, q) = g(Δx, Δy) - g(Σx, Δy) - g(Δx, Σy) + g(Σx, Σy),    Δ = p - q,  Σ = p + q,
    g(x, y) = Σ_kl cos(π k x / n) cos(π l y / m) / (n m a_kl):

all responses are in a table g over the grid.
"""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from core.arrays import Floats, Ints, Points
from core.grid import Grid
from core.linalg.blas import one_thread
from core.linalg.sine_transform import Sines
from core.mapping.features.reduced_system import as_one
from core.mapping.jacobians import Complexes

_PAIRS_AT_ONCE = 1 << 16
Scalar = TypeVar("Scalar", np.float64, np.complex128)


class HeldPlate:
    """Responses of a grid whose outline stays where it is, to forces at any places of the picture.

    Parameters
    ----------
    cell
        Width and height of a cell in units of their mean.
    rounded
        ℓ in cells.
    """

    def __init__(self, grid: Grid, *, cell: tuple[float, float], rounded: float) -> None:
        self._grid = grid
        self._x, self._y = Sines(grid.columns - 1), Sines(grid.rows - 1)
        t = self._y.eigenvalues[:, None] / cell[1] ** 2 + self._x.eigenvalues / cell[0] ** 2
        self._stiffness = t + rounded**2 * t**2
        with one_thread():
            table = self._x.cosine_sums(self._y.cosine_sums(1 / self._stiffness, axis=0), axis=1)
        self._table = table / (self._x.count * self._y.count)
        self._points: Points = np.empty((0, 2))
        self._S: Floats = np.empty((0, 0))

    def hold(self, points: Points) -> Floats:
        """Declare the places (n, 2) of the forces and return S (n, n): what a force at one moves another."""
        before, S = known_responses(points, self._points, self._S)
        new = before < 0
        number = np.arange(len(points))
        i, j = np.nonzero(new[:, None] & (~new | (number <= number[:, None])))
        for start in range(0, len(i), _PAIRS_AT_ONCE):
            pairs = slice(start, start + _PAIRS_AT_ONCE)
            S[i[pairs], j[pairs]] = self._between(points[i[pairs]], points[j[pairs]])
        S[j, i] = S[i, j]
        self._points, self._S = points.copy(), S
        return S

    def answer(self, forces: Complexes) -> Complexes:
        """Return d (N,) for the forces (n,) at the places."""
        x, y = (sines.between(*self._split(self._points, axis)) for axis, sines in enumerate((self._x, self._y)))
        rows, columns = self._stiffness.shape
        with one_thread():
            load = y.T @ np.concatenate([forces.real[:, None] * x, forces.imag[:, None] * x], axis=1)
            load.reshape(rows, 2, columns)[:] /= self._stiffness[:, None]
            down = self._y.sums(load, axis=0).reshape(-1, columns)
            found = self._x.sums(down, axis=1).reshape(self._grid.rows, 2, -1)
        return as_one(np.moveaxis(found, 1, 2).reshape(-1, 2))

    def solve_poisson(self, load: Complexes) -> Complexes:
        """Return y (R, C), 0 on the outline, with dᵀ w d y = `load` (R, C) inside, w = 1 for every quad."""
        values = np.stack([load.real, load.imag])[:, 1:-1, 1:-1]
        # An inner edge belongs to two quads.
        stiffness = 2 * (self._y.eigenvalues[:, None] + self._x.eigenvalues)
        found = self._both(values)[:, 1:-1, 1:-1] / stiffness
        whole = self._both(found)
        return np.asarray(whole[0] + 1j * whole[1])

    def _both(self, table: Floats) -> Floats:
        """Return the sums of sines with coefficients `table` (2, r, c) at all nodes (2, R, C)."""
        rows, columns = table.shape[1:]
        down = self._y.sums(np.moveaxis(table, 0, 1).reshape(rows, -1), axis=0).reshape(-1, columns)
        found = self._x.sums(down, axis=1).reshape(self._grid.rows, 2, -1)
        return np.ascontiguousarray(np.moveaxis(found, 1, 0))

    def _split(self, points: Points, axis: int) -> tuple[Ints, Floats]:
        """Return the cell of each place along an axis, and the share of it that lies before the place."""
        place = (points[:, axis] + 0.5) / self._grid.cell[axis]
        cell = np.clip(place.astype(np.int64), 0, self._grid.shape[1 - axis] - 2)
        return cell, place - cell

    def _between(self, p: Points, q: Points) -> Floats:
        """Return what a force at each of `p` (n, 2) moves the place of `q` with the same number."""
        (x, by_x), (y, by_y) = (
            _distances(*self._split(p, axis), *self._split(q, axis), self._grid.shape[1 - axis] - 1) for axis in (0, 1)
        )
        S = np.zeros(len(p))
        for place, share in zip(y * self._grid.columns, by_y, strict=True):
            S += share * np.einsum("an,an->n", by_x, self._table.take(place + x))
        return S


def known_responses(points: Points, before: Points, S: NDArray[Scalar]) -> tuple[Ints, NDArray[Scalar]]:
    """Return which of the places `before` each of `points` (n, 2) is, -1 for none, and what of S (n, n) is known."""
    known = {tuple(point): i for i, point in enumerate(before.tolist())}
    number = np.array([known.get(tuple(point), -1) for point in points.tolist()], np.int64)
    old = np.flatnonzero(number >= 0)
    found = np.zeros((len(points), len(points)), S.dtype)
    found[np.ix_(old, old)] = S[np.ix_(number[old], number[old])]
    return number, found


def _distances(a: Ints, u: Floats, b: Ints, v: Floats, count: int) -> tuple[Ints, Floats]:
    """Return Δ and Σ (6, n) along an axis between the nodes around two places, and the weights of g there.

    A place in cell a, u into it, has the node a with the weight 1 - u and a + 1 with u. Beyond `count` cells, g runs
    back as a mirror has it.
    """
    step = np.arange(3)[:, None]
    apart, total = np.abs(a - b + step - 1), a + b + step
    both, neither = u * v, (1 - u) * (1 - v)
    one, other = u * (1 - v), (1 - u) * v
    weights = np.stack([other, both + neither, one, -neither, -(one + other), -both])
    return np.concatenate([apart, np.where(total > count, 2 * count - total, total)]), weights
