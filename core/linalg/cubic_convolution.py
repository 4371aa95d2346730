"""What is smooth, worked out on a coarse grid and refined by cubic convolution  [Keys 1981]."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from core.arrays import Floats, Ints

Complexes = NDArray[np.complex128]
_KEPT = 8
"""So many lists of nodes that are read again and again have their weights kept."""
_STRIP = 16
"""Rows of a thousand complex numbers that the processor has at hand at once, with those that they are made of."""


class CubicConvolution:
    """From the nodes of a coarse grid to those of a finer one over the same picture, shapes (r, c) and (R, C)."""

    def __init__(self, coarse: tuple[int, int], fine: tuple[int, int]) -> None:
        self.shape = fine
        self.down, self.across = (cubic_weights(np.linspace(0, m - 1, n), m) for n, m in zip(fine, coarse, strict=True))
        self._known: dict[int, tuple[object, scipy.sparse.csr_array]] = {}

    def refine(self, d: Complexes) -> Complexes:
        """Return at the fine grid's nodes (R, C) what d (r, c) is at the coarse one's."""
        by_row, by_column = self._strips
        return _apply(by_row, np.ascontiguousarray(_apply(by_column, np.ascontiguousarray(d.T)).T))

    def read(self, d: Complexes, nodes: Ints) -> Complexes:
        """Return the same at some nodes of the fine grid (...)."""
        weights = self._keep(nodes, lambda: self._weights_at(nodes.ravel()))
        found = weights @ np.ascontiguousarray(d).reshape(-1, 1).view(np.float64)
        return np.asarray(found).view(np.complex128).reshape(nodes.shape)

    def combine(self, d: Complexes, matrix: "scipy.sparse.csr_array", nodes: Ints) -> Complexes:
        """Return a matrix (q, n) times the same at n nodes."""
        weights = self._keep(matrix, lambda: scipy.sparse.csr_array(matrix @ self._weights_at(nodes)))
        return np.asarray(weights @ d.ravel())

    def _keep(self, of: object, make: "Callable[[], scipy.sparse.csr_array]") -> "scipy.sparse.csr_array":
        """Return the weights that belong to an object, made once while not too many others come between."""
        if id(of) not in self._known:
            if len(self._known) == _KEPT:
                del self._known[next(iter(self._known))]
            self._known[id(of)] = of, make()
        return self._known[id(of)][1]

    def _weights_at(self, nodes: Ints) -> "scipy.sparse.csr_array":
        (rows, by_row), (columns, by_column) = self.taps
        row, column = np.divmod(nodes, self.shape[1])
        places = rows[row][:, :, None] * self.across.shape[1] + columns[column][:, None, :]
        weights = by_row[row][:, :, None] * by_column[column][:, None, :]
        ends = np.arange(len(nodes) + 1) * 16
        size = self.down.shape[1] * self.across.shape[1]
        return scipy.sparse.csr_array((weights.ravel(), places.ravel(), ends), (len(nodes), size))

    @cached_property
    def _strips(self) -> tuple[list["_Strip"], list["_Strip"]]:
        """Those of the rows and of the columns."""
        return _strips_of(self.down), _strips_of(self.across)

    @cached_property
    def taps(self) -> tuple[tuple[Ints, Floats], tuple[Ints, Floats]]:
        """The coarse rows, and the coarse columns, that each fine one is read from, four each, and their weights."""
        return _taps(self.down), _taps(self.across)


@dataclass(frozen=True, eq=False)
class _Strip:
    """Some rows of a matrix that has few numbers, close together, in each."""

    rows: slice
    columns: slice
    """Those in which these rows have all of theirs."""
    values: Floats
    """What is there."""


def _strips_of(matrix: "scipy.sparse.csr_array") -> list[_Strip]:
    """Cut a matrix into strips of rows."""
    found = []
    for first in range(0, matrix.shape[0], _STRIP):
        part = matrix[first : first + _STRIP].tocsr()
        columns = slice(int(part.indices.min()), int(part.indices.max()) + 1)
        found.append(_Strip(slice(first, first + part.shape[0]), columns, part[:, columns].toarray()))
    return found


def _apply(strips: list[_Strip], z: Complexes) -> Complexes:
    """Return the strips' matrix (n, m) times z (m, k): as dense products, which write each number once."""
    found = np.empty((strips[-1].rows.stop, z.shape[1]), np.complex128)
    there, real = found.view(np.float64), z.view(np.float64)
    for strip in strips:
        np.matmul(strip.values, real[strip.columns], out=there[strip.rows])
    return found


@dataclass(frozen=True, eq=False)
class Smooth:
    """A field on a grid (R, C): all of it, or what it is refined from."""

    d: Complexes
    """At the nodes of that grid, or of a coarser one (r, c)."""
    cubic: CubicConvolution | None = None
    """What refines it."""

    @cached_property
    def whole(self) -> Complexes:
        """What it is at all nodes (R, C)."""
        return self.d if self.cubic is None else self.cubic.refine(self.d)

    def read(self, nodes: Ints) -> Complexes:
        """Return what it is at some nodes (...)."""
        return self.d.ravel()[nodes] if self.cubic is None else self.cubic.read(self.d, nodes)

    def combine(self, matrix: "scipy.sparse.csr_array", nodes: Ints) -> Complexes:
        """Return a matrix (q, n) times what it is at n nodes."""
        if self.cubic is not None:
            return self.cubic.combine(self.d, matrix, nodes)
        return np.asarray(matrix @ self.d.ravel()[nodes])


def _taps(weights: "scipy.sparse.csr_array") -> tuple[Ints, Floats]:
    """Return columns and values of a matrix of at most four to a row, (n, 4) each."""
    there = np.arange(4) < np.diff(weights.indptr)[:, None]
    columns, values = np.zeros(there.shape, np.int64), np.zeros(there.shape)
    columns[there], values[there] = weights.indices, weights.data
    return columns, values


def cubic_weights(at: Floats, count: int) -> "scipy.sparse.csr_array":
    """Return the (n, count) matrix that takes values at 0, 1, ... to places `at` (n,), by Catmull-Rom's cubic.

    Past the first and last value the curve is continued in a straight line.
    """
    left = np.clip(np.floor(at).astype(np.int64), 0, count - 2)
    t = at - left
    shares = np.stack([-t + 2 * t**2 - t**3, 2 - 5 * t**2 + 3 * t**3, t + 4 * t**2 - 3 * t**3, t**3 - t**2], -1) / 2
    rows = np.repeat(np.arange(len(at)), 4)
    columns = (left[:, None] + np.arange(4)).ravel()
    whole = scipy.sparse.csr_array((shares.ravel(), (rows, columns)), shape=(len(at), count + 2))
    # The values beyond both ends are 2 v0 - v1 and 2 v(n-1) - v(n-2).
    ends = scipy.sparse.lil_array((count + 2, count))
    ends[np.arange(1, count + 1), np.arange(count)] = 1.0
    ends[0, 0] = ends[-1, -1] = 2.0
    ends[0, 1] = ends[-1, -2] = -1.0
    return scipy.sparse.csr_array(whole @ scipy.sparse.csr_array(ends))
