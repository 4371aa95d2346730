"""A membrane over a grid of nodes, held at points: Laplace's equation without a factor, whatever the points are.

With K the graph Laplacian of the nodes, 0 on the border, B the bilinear weights at the points and w how hard they are
held, Woodbury's identity turns the large system into one as large as there are points (the capacitance matrix method,
B. L. Buzbee, F. W. Dorr, J. A. George and G. H. Golub 1971):

    (K + B'WB) u = B'W v    <=>    u = K^-1 B'q,    (S + W^-1) q = v,    S = B K^-1 B'

K is diagonal in sines. S needs sines along one axis only: for the wave of eigenvalue a = 2 - 2 cos(pi i / n) the other
axis, of N cells, has the tridiagonal matrix with 2 + a beside -1, whose inverse is, with 2 cosh(h) = 2 + a and p <= q,

    g(p, q) = sinh(p h) sinh((N - q) h) / (sinh(h) sinh(N h)),

a product of what belongs to p and what belongs to q: all of S is one product of matrices. For p = q + 1 that product is
larger than g(q, p) by exactly 1, which matters where two points lie in one cell.
"""

import numpy as np
import scipy

from core.arrays import Floats, Ints, Points


class Membrane:
    """A grid of (rows, columns) nodes, 0 on its border; everything that does not depend on the points, built once."""

    def __init__(self, rows: int, columns: int) -> None:
        self.shape = (rows, columns)
        self._short = 0 if columns <= rows else 1
        """The axis of places (0 for x) along which the inverse is written out: exponents stay small on the shorter."""
        cells, waves = (self.shape[1 - axis] - 1 for axis in (self._short, 1 - self._short))
        number = np.arange(1, waves)
        exponent = np.arccosh(2 - np.cos(np.pi * number / waves))
        node = np.arange(cells + 1)[:, None]
        self._waves = np.sqrt(2 / waves) * np.sin(np.pi * np.outer(np.arange(waves + 1), number) / waves)
        """(nodes, waves) along the longer axis."""
        # sinh(p h) = e^(ph) (1 - e^(-2ph)) / 2, and both sides of the product are taken from the middle of the axis.
        scale = 2 * np.sinh(exponent) * -np.expm1(-2 * cells * exponent)
        self._before = np.exp((node - cells / 2) * exponent) * -np.expm1(-2 * node * exponent) / scale
        self._after = np.exp((cells / 2 - node) * exponent) * -np.expm1(-2 * (cells - node) * exponent)
        stretch = [2 - 2 * np.cos(np.pi * np.arange(1, n - 1) / (n - 1)) for n in self.shape]
        self._eigenvalues = stretch[0][:, None] + stretch[1]

    def held(self, places: Points, values: Floats, hold: Floats) -> Floats:
        """Return the field (rows, columns, d) that is about `values` (n, d) at `places` (n, 2).

        Places are (x, y) in cells, within the grid; `hold` (n,) is how hard each value is held, against an edge of the
        grid.
        """
        limit = np.array(self.shape[::-1]) - 2
        cell = np.clip(np.floor(places).astype(int), 0, limit)
        share = places - cell
        matrix = self._response(cell, share)
        matrix[np.diag_indices_from(matrix)] += 1 / hold
        charges = scipy.linalg.solve(matrix, values, assume_a="pos", overwrite_a=True, check_finite=False)
        field = np.zeros((*self.shape, values.shape[1]))
        for right in (0, 1):
            for down in (0, 1):
                weight = np.abs(1 - right - share[:, 0]) * np.abs(1 - down - share[:, 1])
                np.add.at(field, (cell[:, 1] + down, cell[:, 0] + right), weight[:, None] * charges)
        waves = scipy.fft.dstn(field[1:-1, 1:-1], type=1, axes=(0, 1), norm="ortho") / self._eigenvalues[..., None]
        field[...] = 0
        field[1:-1, 1:-1] = scipy.fft.idstn(waves, type=1, axes=(0, 1), norm="ortho")
        return field

    def _response(self, cell: Ints, share: Floats) -> Floats:
        """Return S (n, n): the field at every point for a unit load at every other."""
        order = np.argsort(cell[:, self._short], kind="stable")
        (p, f), (r, g) = ((cell[order, axis], share[order, axis, None]) for axis in (self._short, 1 - self._short))
        waves = (1 - g) * self._waves[r] + g * self._waves[r + 1]
        before = waves * ((1 - f) * self._before[p] + f * self._before[p + 1])
        after = waves * ((1 - f) * self._after[p] + f * self._after[p + 1])
        upper = before @ after.T
        together = p[:, None] == p
        upper -= np.where(together, f * (1 - f.T), 0) * (waves @ waves.T)
        upper = np.triu(upper)
        result: Floats = np.empty_like(upper)
        result[np.ix_(order, order)] = upper + np.triu(upper, 1).T
        return result
