"""Sum small dense element matrices into one sparse system over the unknowns that they share.

Matrices are symmetric: of each, only the upper triangle is kept, row by row.
"""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.arrays import Floats, Ints
from core.linalg.factor import Entries, Factor

_REGULAR = 1e-9
"""Share of itself that is added to every diagonal entry: a large feature's is greater than a node's by many orders."""


class Assembly:
    """The sparse system of Newton's method, its pattern found once.

    Parameters
    ----------
    count
        Number of unknowns.
    element_dofs
        For each kind of element, the unknowns (m, k) of its m elements; `count` stands for none.
    """

    def __init__(self, count: int, element_dofs: list[Ints]) -> None:
        self.count, self._dofs = count, element_dofs
        pairs = [_pairs(dofs, count) for dofs in element_dofs]
        self._twice = [_met_twice(dofs, count) for dofs in element_dofs]
        diagonal = np.arange(count) * (count + 1)
        keys = np.sort(np.concatenate([*(p[p < count * count] for p in pairs), diagonal]))
        keys = keys[np.diff(keys, prepend=-1) > 0]
        self._slots = [np.searchsorted(keys, p) for p in pairs]
        self.diagonal = np.searchsorted(keys, diagonal)
        self._entries = len(keys)
        column, row = np.divmod(keys, count)
        ones = (row == column).astype(np.float64)
        self._factor = Factor(Entries(row, column, ones, count), pattern_only=True)

    def gradient(self, parts: list[Floats]) -> Floats:
        """Return the sum (count,) of the elements' gradients, (m, k) for each kind."""
        return np.asarray(np.sum([_sum_up(d, p, self.count) for d, p in zip(self._dofs, parts, strict=True)], axis=0))

    def entries(self, parts: list[Floats]) -> Floats:
        """Return the stored entries of the sum of the elements' matrices, packed (m, k (k + 1) / 2) for each kind."""
        total = np.zeros(self._entries)
        for slots, twice, part in zip(self._slots, self._twice, parts, strict=True):
            values = part.ravel()
            total += _sum_up(slots, values, self._entries)
            if twice.size:
                total += _sum_up(slots[twice], values[twice], self._entries)
        return total

    def solve(self, entries: Floats, b: Floats) -> Floats:
        """Solve the system of the given entries for b (count,); an unknown without an equation is 0."""
        return self.factorise(entries).solve(b)

    def factorise(self, entries: Floats) -> Factor:
        """Factorise the system of the given entries; an unknown without an equation becomes 0."""
        diagonal = entries[self.diagonal]
        entries[self.diagonal] = np.where(diagonal > 0, (1 + _REGULAR) * diagonal, 1.0)
        return self._factor.factorise(entries)


def _sum_up(places: Ints, values: Floats, count: int) -> Floats:
    """Add up `values` by their places below `count`."""
    return np.asarray(np.bincount(places.ravel(), values.ravel(), count + 1)[:-1], np.float64)


@cache
def triangle(size: int) -> tuple[Ints, Ints]:
    """Return rows and columns of what is kept of matrices of a size."""
    row, column = np.triu_indices(size)
    return row, column


def pack(matrices: NDArray[Any]) -> Floats:
    """Return what is kept of matrices (m, k, k)."""
    size = matrices.shape[-1]
    row, column = triangle(size)
    kept = matrices.reshape(len(matrices), size * size).take(row * size + column, axis=1)
    return np.asarray(kept, np.float64)


def _pairs(dofs: Ints, count: int) -> Ints:
    """Return the place in the lower triangle, by columns, of every pair of an element's unknowns; count² for none."""
    one, other = (dofs[:, k] for k in triangle(dofs.shape[1]))
    row, column = np.maximum(one, other), np.minimum(one, other)
    return np.where(row < count, column * count + row, count * count).ravel()


def _met_twice(dofs: Ints, count: int) -> Ints:
    """Return which of the pairs are of one unknown with itself at two places of an element, in both orders."""
    row, column = triangle(dofs.shape[1])
    return np.flatnonzero((dofs[:, row] == dofs[:, column]) & (dofs[:, row] < count) & (row != column))
