"""Sums of sines along an axis of a grid, which vanish at both of its ends.

Over n cells they are s_k(x) = √(2 / n) sin(π k x / n), k = 1 … n - 1, orthonormal on the nodes x = 1 … n - 1. A short
axis has them in a matrix, so that sums are a product; a long one sums by a fast transform, on all cores.
"""

import os
from functools import cached_property

import numpy as np
import scipy

from core.arrays import Floats, Ints

_SHORT = 700
"""Cells up to which a product takes less time than most transforms; of a prime count they are slow."""


class Sines:
    """The sines over `count` cells; coefficients of all that are summed are those of k = 1 … count - 1."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._is_short = count <= _SHORT

    @cached_property
    def eigenvalues(self) -> Floats:
        """What twice the value less those on both sides is to the value, at every node, for every sine."""
        return np.asarray(4 * np.sin(np.pi * np.arange(1, self.count) / (2 * self.count)) ** 2)

    def split(self, places: Floats) -> tuple[Ints, Floats]:
        """Return the cell that each of `places` (n,), in cells, is in, and which share of the cell lies before it."""
        cell = np.clip(np.floor(places).astype(np.int64), 0, self.count - 1)
        return cell, places - cell

    def between(self, cell: Ints, share: Floats) -> Floats:
        """Return all sines (n, count - 1), continued linearly from node to node, `share` (n,) into a `cell` (n,)."""
        return (1 - share)[:, None] * self._at(cell) + share[:, None] * self._at(cell + 1)

    def sums(self, coefficients: Floats, *, axis: int) -> Floats:
        """Return Σ c_k s_k at all nodes, k along the last `axis` but one, -2, or the last, -1, of coefficients.

        Sines of odd k are the same on both sides of the middle, those of even k change their sign there: products are
        worked out for one half.
        """
        shape = list(coefficients.shape)
        shape[axis] = self.count + 1
        if not self._is_short:
            found = np.zeros(shape)
            inner = found[..., 1:-1] if axis == -1 else found[..., 1:-1, :]
            inner[...] = scipy.fft.dst(coefficients, type=1, axis=axis, norm="ortho", workers=os.cpu_count())
            return found
        if axis == -2:
            odd, even = (half @ coefficients[..., k::2, :] for k, half in enumerate(self._halves))
        else:
            odd, even = (coefficients[..., k::2] @ half.T for k, half in enumerate(self._halves))
        found, middle = np.empty(shape), odd.shape[axis]
        first, last = found.swapaxes(axis, -1)[..., :middle], found.swapaxes(axis, -1)[..., : -middle - 1 : -1]
        np.add(odd.swapaxes(axis, -1), even.swapaxes(axis, -1), out=first)
        np.subtract(odd.swapaxes(axis, -1), even.swapaxes(axis, -1), out=last)
        return found

    @cached_property
    def _halves(self) -> tuple[Floats, Floats]:
        """Sines of odd and of even k at the nodes up to the middle."""
        values = self._matrix[: self.count // 2 + 1]
        return np.ascontiguousarray(values[:, ::2]), np.ascontiguousarray(values[:, 1::2])

    @cached_property
    def _matrix(self) -> Floats:
        return self._values(np.arange(self.count + 1))

    def _at(self, nodes: Ints) -> Floats:
        return self._matrix[nodes] if self._is_short else self._values(nodes)

    def _values(self, nodes: Ints) -> Floats:
        """Return all sines at some nodes (n, count - 1)."""
        # Whole turns are taken from k x, so that no digits are lost.
        turns = np.outer(nodes, np.arange(1, self.count)) % (2 * self.count)
        values = np.sqrt(2 / self.count) * np.sin(np.pi / self.count * turns)
        return np.where((nodes % self.count == 0)[:, None], 0.0, values)
