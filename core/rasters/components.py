"""The 8-connected components of a raster, found anew only where it has changed.

A raster is cut into regions of a few tiles. Each has components of its own; those that touch across a border between
regions are one. Components are numbered as `cv2.connectedComponents` numbers them: by the first of the blocks of four
pixels, row by row, in which a pixel of theirs lies.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from core.arrays import Bytes, Ints
from core.rasters.raster import TILE_PX, Raster

Labels = NDArray[np.int32]

REGION_PX = 2 * TILE_PX
"""Side of a region: large enough for few to be joined, small enough to be searched again."""
MARKED = 127
"""Pixels above this value belong to a component."""


class Components:
    """Which component chosen pixels of a raster are in, kept up to date while the raster is painted.

    Parameters
    ----------
    rows, columns
        Of the chosen pixels, ascending: all (row, column) of these.
    """

    def __init__(self, rows: Ints, columns: Ints) -> None:
        self._rows, self._columns = rows, columns
        self._seen: Raster | None = None

    def labels(self, raster: Raster) -> Labels:
        """Return the number (R, C) of the component that each chosen pixel is in, 0 for none."""
        seen = self._seen
        if seen is None or (seen.width_px, seen.height_px) != (raster.width_px, raster.height_px):
            self._begin(raster)
        changed = {(box[1] // REGION_PX, box[0] // REGION_PX) for box, _ in raster.changed_boxes(self._seen)}
        for y, x in sorted(changed):
            self._search(raster, y, x)
        self._seen = raster
        return self._joined()

    def _begin(self, raster: Raster) -> None:
        """Forget what was known, and make room for a raster of this size."""
        width, height = raster.width_px, raster.height_px
        self._seen = None
        down, across = -(-height // REGION_PX), -(-width // REGION_PX)
        self._local = np.zeros((len(self._rows), len(self._columns)), np.int32)
        """Numbers of components in their own regions, at the chosen pixels."""
        self._first: list[list[Ints]] = [[np.empty(0, np.int64)] * across for _ in range(down)]
        """By region, the number of the first block of each component."""
        self._top, self._bottom = np.zeros((2, down, width), np.int32)
        self._left, self._right = np.zeros((2, across, height), np.int32)
        """Numbers of components along the sides of the regions."""

    def _search(self, raster: Raster, y: int, x: int) -> None:
        """Find the components of a region."""
        left, top = x * REGION_PX, y * REGION_PX
        right, bottom = min(left + REGION_PX, raster.width_px), min(top + REGION_PX, raster.height_px)
        labels, count = _searched(raster.part((left, top, right, bottom)))
        self._first[y][x] = _first_blocks(labels, count, (left, top), -(-raster.width_px // 2))
        self._top[y, left:right], self._bottom[y, left:right] = labels[0], labels[-1]
        self._left[x, top:bottom], self._right[x, top:bottom] = labels[:, 0], labels[:, -1]
        rows = slice(*np.searchsorted(self._rows, (top, bottom)))
        columns = slice(*np.searchsorted(self._columns, (left, right)))
        self._local[rows, columns] = labels[np.ix_(self._rows[rows] - top, self._columns[columns] - left)]

    def _joined(self) -> Labels:
        """Return the numbers at the chosen pixels, with what touches across borders made one."""
        counts = np.array([[len(first) for first in line] for line in self._first])
        before = (np.cumsum(counts) - counts.ravel()).reshape(counts.shape).astype(np.int32)
        total = int(counts.sum())
        number = np.arange(1, total + 1)
        if counts.size > 1 and total:
            number = _ranks(self._roots(before, total), np.concatenate([f for line in self._first for f in line]))
        table = np.append(0, number).astype(np.int32)
        where = np.ix_(self._rows // REGION_PX, self._columns // REGION_PX)
        return np.asarray(table[_number(self._local, before[where])])

    def _roots(self, before: Ints, total: int) -> Ints:
        """Return for each component of a region the one (of the whole raster) that it is part of."""
        height, width = self._left.shape[1], self._top.shape[1]
        across, down = (np.repeat(b, REGION_PX, axis=1)[:, :size] for b, size in ((before, width), (before.T, height)))
        pairs = [
            *_touching(_number(self._bottom[:-1], across[:-1]), _number(self._top[1:], across[1:])),
            *_touching(_number(self._right[:-1], down[:-1]), _number(self._left[1:], down[1:])),
        ]
        one, other = (np.concatenate([pair[side] for pair in pairs]) - 1 for side in (0, 1))
        root = np.arange(total)
        while (root[one] != root[other]).any():
            least = np.minimum(root[one], root[other])
            np.minimum.at(root, root[one], least)
            np.minimum.at(root, root[other], least)
            root = root[root]
        return root


def _searched(values: Bytes) -> tuple[Labels, int]:
    """Return the numbers of components at the pixels of a region, and how many numbers there are, 0 included."""
    if values.max() <= MARKED:
        return np.zeros(values.shape, np.int32), 1
    if values.min() > MARKED:
        return np.ones(values.shape, np.int32), 2
    _, marked = cv2.threshold(values, MARKED, 1, cv2.THRESH_BINARY)
    count, found = cv2.connectedComponents(marked, connectivity=8)
    return np.asarray(found, np.int32), count


def _first_blocks(labels: Labels, count: int, corner: tuple[int, int], blocks_across: int) -> Ints:
    """Return the number of the first block of each of the components 1 … count - 1 of a region."""
    if count == 1:
        return np.empty(0, np.int64)
    if count == 2 and labels[0, 0]:
        return np.array([corner[1] // 2 * blocks_across + corner[0] // 2])
    height, width = labels.shape
    even = labels if height % 2 == width % 2 == 0 else np.pad(labels, ((0, height % 2), (0, width % 2)))
    blocks = np.maximum(np.maximum(even[::2, ::2], even[::2, 1::2]), np.maximum(even[1::2, ::2], even[1::2, 1::2]))
    row, column = blocks.nonzero()
    first = np.zeros(count, np.int64)
    # Of several values for one place the last one stays.
    first[blocks[row, column][::-1]] = ((row + corner[1] // 2) * blocks_across + column + corner[0] // 2)[::-1]
    return first[1:]


def _number(local: Labels, before: Ints) -> Labels:
    """Return numbers that are unique among all regions, from 1, for those in regions; 0 stays."""
    return np.asarray(np.where(local > 0, local + before, 0), np.int32)


def _touching(one: Labels, other: Labels) -> list[tuple[Labels, Labels]]:
    """Return pairs of components that have pixels beside one another, or corner to corner, on two sides of borders."""
    pairs = []
    for a, b in ((one, other), (one[:, 1:], other[:, :-1]), (one[:, :-1], other[:, 1:])):
        both = (a > 0) & (b > 0)
        a, b = a[both], b[both]
        new = np.append(True, (a[1:] != a[:-1]) | (b[1:] != b[:-1]))[: len(a)]
        pairs.append((a[new], b[new]))
    return pairs


def _ranks(roots: Ints, first: Ints) -> Ints:
    """Return the number of each component of a region, from 1, by the first block of the whole that it is part of."""
    earliest = np.full(int(roots.max()) + 1, np.iinfo(np.int64).max)
    np.minimum.at(earliest, roots, first)
    rank = np.empty_like(earliest)
    rank[np.argsort(earliest)] = np.arange(1, len(earliest) + 1)
    return np.asarray(rank[roots])
