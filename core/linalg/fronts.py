"""Fronts of a nested dissection, and what elimination makes of them  (the multifrontal method of Duff & Reid 1983).

With A the front of a box, its own entries of the matrix and what its halves have left on their frames,

    A₁₁ = L Lᵀ,   Y = L⁻¹ A₁₂,   S = A₂₂ - Yᵀ Y,

1 its pivots, 2 its frame, S what it leaves to the box that it is half of. Of a leaf L⁻ᵀ Y is kept in place of Y: where
no load is, its pivots follow from its frame by that alone, and L, most of its numbers, is not read.
"""

import numpy as np
import scipy

from core.arrays import Floats, Ints
from core.linalg.dissection import Group, Place

_BATCH = 1 << 17
"""Entries of the fronts that are worked on at a time, which stay in the processor's cache."""
_LARGE = 13
"""Pivots from which on a front is worth a call of its own."""
_HALVED = 150
"""Nodes of a frame from which on the symmetry of S saves work."""
_BLOCK = 150
"""Pivots of a front that are inverted at once: more take longer than solving block by block, and SciPy keeps the
interpreter to itself meanwhile."""


class Fronts:
    """The fronts of a group of boxes on a grid of a `shape`, numbered from `first` among all boxes.

    The grid has a margin of one node on every side of what is dissected. A place outside it is represented by node 0,
    which is uncoupled from all others too.
    """

    def __init__(self, group: Group, shape: tuple[int, int], first: int, number: int, *, is_kept: bool) -> None:
        self.group, self.first, self.number, self.count = group, first, number, len(group.corners)
        self.is_kept = is_kept
        """Whether S is kept; boxes of which it is not are eliminated again with the least one around them that is."""
        own, around = group.pivots(), group.frame()
        self.pivots, self.size = len(own), len(own) + len(around)
        row, column = np.array(group.corners).T[..., None] + np.array(own + around).T[:, None] + 1
        inside = (row < shape[0]) & (column < shape[1])
        self.nodes = np.where(inside, row * shape[1] + column, 0)
        """Of the grid (boxes, size): pivots, then frame."""
        self.own = slice(0)
        """Where pivots are in the order of elimination, one box after the other."""
        self.around = np.empty((0, 0), np.int64)
        """Where frames are (boxes, size - pivots)."""
        self.from_halves: list[Ints] = []
        """Where the frame of a half has the nodes of the front (size,), one past its end for those that it lacks."""
        self._find_entries(own + around)
        self.is_leaf = group.cut is None
        self.factor = np.empty((self.count, self.pivots, self.pivots))
        """L with the blocks on its diagonal inverted, for `solve_lower` and `solve_upper`."""
        self.carry = np.empty((self.count, self.pivots, self.size - self.pivots))
        """Y, or L⁻ᵀ Y of leaves."""
        self._S = np.empty((0, 0, 0))
        self._held = np.arange(0)
        """Which boxes S is known of."""

    def _find_entries(self, front: list[Place]) -> None:
        """Find the entries of the matrix that belong to the boxes, and their places in the fronts."""
        place = {node: k for k, node in enumerate(front)}
        found = []
        for k, (i, j) in enumerate(front[: self.pivots]):
            found.append((k, k, k, 0))
            for kind, (down, right) in ((1, (0, 1)), (2, (1, 0))):
                after, before = place.get((i + down, j + right)), place.get((i - down, j - right))
                if after is not None:
                    found.append((k, after, k, kind))
                # A pivot before this one has named the entry already.
                if before is not None and before >= self.pivots:
                    found.append((k, before, before, kind))
        self._rows, self._others, owners, kinds = np.array(found, np.int64).T
        self.entries = 3 * self.nodes[:, owners] + kinds
        """Of `stencil.node_values`, as one row (boxes, k)."""

    def find_halves(self, halves: "list[Fronts]") -> None:
        """Find out where the frames of the halves of boxes have the nodes of the front."""
        for half, (_, _, runs) in zip(halves, self.group.halves, strict=True):
            places = np.full(self.size, half.size - half.pivots)
            for mine, there in runs:
                places[there] = np.arange(mine.start, mine.stop)
            self.from_halves.append(places)

    def eliminate(self, values: Floats, boxes: Ints, halves: "list[Fronts]") -> None:
        """Eliminate the pivots of some of the boxes; where S is not kept, that of others is forgotten."""
        frame = self.size - self.pivots
        if not self.is_kept:
            self._S, self._held = np.empty((len(boxes), frame, frame)), boxes
        elif not len(self._held):
            self._S, self._held = np.empty((self.count, frame, frame)), np.arange(self.count)
        batch = max(1, _BATCH // self.size**2)
        for start in range(0, len(boxes), batch):
            self._eliminate(values, boxes[start : start + batch], halves)

    def _eliminate(self, values: Floats, boxes: Ints, halves: "list[Fronts]") -> None:
        p, where = self.pivots, stretch(boxes)
        A = np.zeros((len(boxes), self.size, self.size))
        found = values[self.entries[where]]
        A[:, self._rows, self._others] = found
        A[:, self._others, self._rows] = found
        for half, (_, chosen, runs) in zip(halves, self.group.halves, strict=True):
            S = half.left_by(boxes + chosen.start)
            for mine, there in runs:
                for other, across in runs:
                    A[:, there, across] += S[:, mine, other]
        self.factor[where] = factor = _factorise(A[:, :p, :p])
        self.carry[where] = Y = solve_lower(factor, A[:, :p, p:])
        # Of a matrix and itself, half the product is worked out and then copied, which pays off for large ones.
        product = Y.transpose(0, 2, 1) @ (Y if Y.shape[2] >= _HALVED else self.carry[where])
        if self.is_leaf:
            self.carry[where] = solve_upper(factor, Y)
        left = stretch(np.searchsorted(self._held, boxes))
        if isinstance(left, slice):
            np.subtract(A[:, p:, p:], product, out=self._S[left])
        else:
            self._S[left] = A[:, p:, p:] - product

    def left_by(self, boxes: Ints) -> Floats:
        """Return S of boxes that have been eliminated."""
        return np.asarray(self._S[stretch(np.searchsorted(self._held, boxes))])


def stretch(places: Ints) -> Ints | slice:
    """Return ascending places as a slice where none is left out: what it selects is not copied."""
    first, last = int(places[0]), int(places[-1])
    return slice(first, last + 1) if last - first + 1 == len(places) else places


def solve_lower(factor: Floats, b: Floats) -> Floats:
    """Return L⁻¹ b (n, p, k)."""
    if factor.shape[1] <= _BLOCK:
        return factor @ b
    x = np.empty(b.shape)
    for own, before, _ in _blocks(factor.shape[1]):
        x[:, own] = factor[:, own, own] @ (b[:, own] - factor[:, own, before] @ x[:, before])
    return x


def solve_upper(factor: Floats, b: Floats) -> Floats:
    """Return L⁻ᵀ b (n, p, k)."""
    above = factor.transpose(0, 2, 1)
    if factor.shape[1] <= _BLOCK:
        return above @ b
    x = np.empty(b.shape)
    for own, _, behind in reversed(_blocks(factor.shape[1])):
        x[:, own] = above[:, own, own] @ (b[:, own] - above[:, own, behind] @ x[:, behind])
    return x


def _blocks(pivots: int) -> list[tuple[slice, slice, slice]]:
    """Return the blocks that so many pivots are cut into, and what is before and behind each."""
    starts = range(0, pivots, _BLOCK)
    return [(slice(start, start + _BLOCK), slice(start), slice(start + _BLOCK, None)) for start in starts]


def _factorise(A: Floats) -> Floats:
    """Return L of every A = L Lᵀ (n, p, p), the blocks on its diagonal inverted."""
    if A.shape[1] < _LARGE:
        return np.linalg.inv(np.linalg.cholesky(A))
    found = np.empty(A.shape)
    for a, out in zip(A, found, strict=True):
        if len(a) > _BLOCK:
            out[...] = np.linalg.cholesky(a)
            for own, *_ in _blocks(len(a)):
                # By columns, as LAPACK has them, L is upper.
                out[own, own] = scipy.linalg.lapack.dtrtri(out[own, own].T, lower=0)[0].T
            continue
        factor, fault = scipy.linalg.lapack.dpotrf(a.T, lower=0, clean=1)
        if fault:
            raise np.linalg.LinAlgError
        out[...] = scipy.linalg.lapack.dtrtri(factor, lower=0, overwrite_c=1)[0].T
    return found
