"""Equations on a grid that is 0 on its outline, solved by sines: whole fields, and what places do to one another.

The second difference along an axis, T, is diagonal in the sines of that axis (`sine_transform`). On cells of width w
and height h, A = L + s with L = T_x / w² + T_y / h² has sines along one axis only: for the sine of eigenvalue a the
other axis, of N cells, has 1 / w² times the tridiagonal matrix of 2 + c beside -1, c = w² (a / h² + s) (Fourier
analysis, R. W. Hockney 1965). Loads act on places between nodes, and fields are read there, by bilinear weights C. What
a load on one place does to another is

    S = C A⁻¹ Cᵀ

(the capacitance matrix method, B. L. Buzbee, F. W. Dorr, J. A. George and G. H. Golub 1971). With 2 cosh η = 2 + c the
inverse of a tridiagonal matrix is, for p <= q,

    g(p, q) = sinh(p η) sinh((N - q) η) / (sinh(η) sinh(N η)),

a product of what belongs to p and what belongs to q: all of S is one product of matrices. For p = q + 1 that product is
larger than g(q, p) by exactly 1, which matters where two places lie in one cell.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from core.arrays import Floats, Ints, Points
from core.linalg.blas import one_thread
from core.linalg.sine_transform import Sines

_MOST_EXPONENT = 300.0
"""Of e: its square is within the range of floats."""


@dataclass(frozen=True)
class LoadPlaces:
    """Where loads act: on places (n) with sines along y (n, r), by `shares` (n, u) on these u inner `columns`."""

    by_y: Floats
    columns: Ints
    shares: Floats


class DirichletGrid:
    """A grid of (rows, columns) nodes, 0 on its outline, with cells of (width, height); places are (x, y) in cells."""

    def __init__(self, rows: int, columns: int, *, cell: tuple[float, float] = (1.0, 1.0)) -> None:
        self.shape, self.cell = (rows, columns), cell
        self.x, self.y = Sines(columns - 1), Sines(rows - 1)
        self._factors: dict[float, tuple[Floats, Floats]] = {}
        """Of the tridiagonal matrices of all sines along y, one after the other as one matrix, by s."""

    def loads_at(self, places: Points) -> LoadPlaces:
        """Return how loads on places (n, 2) act on the nodes."""
        x, y = places.T
        cell, share = self.x.split(x)
        nodes = np.stack([cell, cell + 1])
        columns = np.setdiff1d(nodes, [0, self.x.count])
        shares = np.where(nodes[..., None] == columns, np.stack([1 - share, share])[..., None], 0).sum(axis=0)
        return LoadPlaces(self.y.between(*self.y.split(y)), columns - 1, shares)

    def spread(self, at: LoadPlaces, loads: Floats, *shifts: float) -> Floats:
        """Return A⁻¹ Cᵀ loads (d, rows, columns) for loads (d, n); with a second shift, less that by the A of it."""
        found = np.zeros((len(loads), self.shape[0] - 2, self.shape[1] - 2))
        with one_thread():
            found[..., at.columns] = at.by_y.T @ (loads[:, :, None] * at.shares)
            others = [self._across(found.copy(), shift) for shift in shifts[1:]]
            found = self._across(found, shifts[0])
            for other in others:
                found -= other
            return self._sum(found)

    def solve(self, load: Floats, shift: float = 0.0) -> Floats:
        """Return A⁻¹ `load` (d, rows, columns), of which only inner nodes count."""
        with one_thread():
            waves = self.y.sums(load[:, 1:-1, 1:-1], axis=-2)[:, 1:-1]
            return self._sum(self._across(np.ascontiguousarray(waves), shift))

    def _across(self, waves: Floats, shift: float) -> Floats:
        """Return A⁻¹ in place of waves (d, r, c), sines along y."""
        if shift not in self._factors:
            width, height = self.cell
            diagonal = np.repeat(2 + width**2 * (self.y.eigenvalues / height**2 + shift), self.shape[1] - 2)
            beside = np.full(diagonal.shape, -1.0)
            beside[self.shape[1] - 3 :: self.shape[1] - 2] = 0
            self._factors[shift] = scipy.linalg.lapack.dpttrf(diagonal, beside[: max(len(beside) - 1, 1)])[:2]
        for part in waves.reshape(len(waves), -1):  # one call each: LAPACK keeps the interpreter to itself meanwhile
            part[:] = scipy.linalg.lapack.dpttrs(*self._factors[shift], part, overwrite_b=1)[0]
        waves *= self.cell[0] ** 2
        return waves

    def _sum(self, waves: Floats) -> Floats:
        """Return the sums of sines along y with coefficients (d, r, c) at all nodes (d, rows, columns)."""
        found = np.zeros((len(waves), *self.shape))
        found[..., 1:-1] = self.y.sums(waves, axis=-2)
        return found


class Responses:
    """S on a grid with A = L + s, for any places; what does not depend on them is built once."""

    def __init__(self, grid: DirichletGrid, *, shift: float = 0.0) -> None:
        self._axis = 0 if grid.shape[1] <= grid.shape[0] else 1
        """The axis of places (0 for x) along which the inverse is written out: exponents stay small on the shorter."""
        axes = (grid.x, grid.y)
        self._unit = grid.cell[self._axis] ** 2
        self._along, self._across = axes[self._axis], axes[1 - self._axis]
        size, other = grid.cell[self._axis], grid.cell[1 - self._axis]
        exponent = 2 * np.arcsinh(size / 2 * np.sqrt(self._across.eigenvalues / other**2 + shift))
        cells = self._along.count
        node = np.arange(cells + 1)[:, None]
        # sinh(p η) = e^(pη) (1 - e^(-2pη)) / 2; the powers of e are those of the way from the middle of a strip.
        before = (
            -np.expm1(-2 * node * exponent) * self._unit / (2 * np.sinh(exponent) * -np.expm1(-2 * cells * exponent))
        )
        after = -np.expm1(-2 * (cells - node) * exponent)
        self._strip = max(int(2 * _MOST_EXPONENT / exponent.max()), 1)
        self._tables = [
            (before * np.exp(np.minimum(way, _MOST_EXPONENT)), after * np.exp(np.minimum(-way, _MOST_EXPONENT)))
            for first in range(0, cells, self._strip)
            for way in [(node - first - min(self._strip, cells) / 2) * exponent]
        ]
        """(nodes, sines) of p and of q for each strip of cells that p is in: with more, exponents would overflow."""

    def between(self, places: Points) -> Floats:
        """Return S (n, n): the field at every one of `places` (n, 2) for a unit load on every other."""
        order = np.argsort(places[:, self._axis], kind="stable")
        p, f = self._along.split(places[order, self._axis])
        waves = self._across.between(*self._across.split(places[order, 1 - self._axis]))
        upper = np.zeros((len(places), len(places)))
        f = f[:, None]
        for number, (before, after) in enumerate(self._tables):
            first, last = np.searchsorted(p, [number * self._strip, (number + 1) * self._strip])
            here, on = slice(first, last), slice(first, None)
            left = waves[here] * _interpolate(before, p[here], f[here])
            upper[here, on] = left @ (waves[on] * _interpolate(after, p[on], f[on])).T
        upper -= np.where(p[:, None] == p, self._unit * f * (1 - f.T), 0) * (waves @ waves.T)
        upper = np.triu(upper)
        S: Floats = np.empty_like(upper)
        S[np.ix_(order, order)] = upper + np.triu(upper, 1).T
        return S


def _interpolate(table: Floats, cell: Ints, share: Floats) -> Floats:
    return np.asarray((1 - share) * table[cell] + share * table[cell + 1])
