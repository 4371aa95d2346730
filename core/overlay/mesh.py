"""The triangle mesh that carries texture coordinates and shading over the picture.

Nodes form a regular grid on the picture, `cell` pixels apart, each square cut by the diagonal from its top left to its
bottom right corner. A value at a pixel is the barycentric mean of three nodes (NRT eqs. 4 and 5), so it is linear in
the nodes with weights that are the same in every cell.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias, TypeVar

import cv2
import numpy as np
import scipy
from numpy.typing import NDArray

from core.arrays import Bools, Floats, Ints, Singles
from core.linalg.cubic_convolution import cubic_weights

F = TypeVar("F", Floats, Singles)
Box: TypeAlias = tuple[slice, slice]
"""Rows and columns."""


@dataclass(frozen=True)
class ClothMesh:
    """A grid over a picture of `shape` (H, W); node (r, c) lies at (c, r) * cell - 0.5."""

    shape: tuple[int, int]
    cell: int

    @property
    def cells(self) -> tuple[int, int]:
        """Rows and columns of cells; the last may reach past the picture."""
        return -(-self.shape[0] // self.cell), -(-self.shape[1] // self.cell)

    @property
    def nodes(self) -> tuple[int, int]:
        """Rows and columns of nodes."""
        return self.cells[0] + 1, self.cells[1] + 1

    @cached_property
    def weights(self) -> Floats:
        """(cell², 4): shares of the nodes top left, top right, bottom left, bottom right at its pixels (NRT eq. 5)."""
        t = (np.arange(self.cell) + 0.5) / self.cell
        x, y = (a.ravel() for a in np.meshgrid(t, t))
        return np.stack([1 - np.maximum(x, y), np.maximum(x - y, 0), np.maximum(y - x, 0), np.minimum(x, y)], -1)

    @cached_property
    def corners(self) -> Ints:
        """(rows, columns, 4): node numbers of each cell, as in `weights`."""
        number = np.arange(self.nodes[0] * self.nodes[1]).reshape(self.nodes)
        return np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]], -1)

    def part(self, box: Box) -> "ClothMesh":
        """Return the mesh of the cells in a box, as if the picture was no larger."""
        rows, columns = (len(range(count)[span]) for count, span in zip(self.cells, box, strict=True))
        return ClothMesh((rows * self.cell, columns * self.cell), self.cell)

    def positions(self) -> Floats:
        """Return the places (R, C, 2) of the nodes in the picture."""
        y, x = np.indices(self.nodes).astype(float) * self.cell - 0.5
        return np.stack([x, y], -1)

    def to_pixels(self, values: Floats, cells: Bools) -> Floats:
        """Return node values (R, C, K) at the pixels (H, W, K) of marked cells, linear in each triangle (NRT eq. 4).

        The other pixels are 0.
        """
        k = values.shape[-1]
        inside = np.zeros((*self.cells, self.cell**2, k))
        inside[cells] = self.weights @ values.reshape(-1, k)[self.corners[cells]]
        return self.from_cells(inside)

    def box_of(self, cells: Bools, margin: int) -> tuple[slice, slice]:
        """Return the rows and columns of the pixels that lie in marked cells or `margin` cells around them."""
        rows, columns = around(cells, margin)
        return (
            slice(rows.start * self.cell, min(rows.stop * self.cell, self.shape[0])),
            slice(columns.start * self.cell, min(columns.stop * self.cell, self.shape[1])),
        )

    def smooth_to_pixels(self, values: Floats, box: tuple[slice, slice]) -> Floats:
        """Return node values (R, C, K) at the pixels (h, w, K) of a box by bicubic interpolation."""
        down, across = (
            cubic_weights((np.arange(part.start, part.stop) + 0.5) / self.cell, count)
            for part, count in zip(box, self.nodes, strict=True)
        )
        out = np.empty((*(part.stop - part.start for part in box), values.shape[-1]))
        for k in range(values.shape[-1]):
            out[..., k] = (across @ (down @ values[..., k]).T).T
        return out

    def in_cells(self, image: F) -> F:
        """Return an image (H, W, K) as (rows, columns, cell², K), zero past the picture."""
        rows, columns = self.cells
        h = self.cell
        padded = np.zeros((rows * h, columns * h, image.shape[-1]), image.dtype)
        padded[: self.shape[0], : self.shape[1]] = image
        blocks = padded.reshape(rows, h, columns, h, -1).swapaxes(1, 2)
        return np.asarray(blocks.reshape(rows, columns, h * h, -1), image.dtype)

    def from_cells(self, blocks: Floats) -> Floats:
        """Return (rows, columns, cell², K) as an image (H, W, K)."""
        rows, columns = self.cells
        h = self.cell
        image = blocks.reshape(rows, columns, h, h, -1).swapaxes(1, 2).reshape(rows * h, columns * h, -1)
        return image[: self.shape[0], : self.shape[1]]

    def cell_means(self, image: Floats) -> Floats:
        """Return the mean (rows, columns) of a plane (H, W) over each cell's part of the picture."""
        sums, area = image, np.ones(())
        for axis, count in enumerate(self.shape):
            first = np.arange(0, count, self.cell)
            sums = np.add.reduceat(sums, first, axis)
            area = np.multiply.outer(area, np.diff(first, append=count))
        return np.asarray(sums / area, np.float64)

    def pixels_of(self, cells: Bools) -> Bools:
        """Return which pixels (H, W) lie in marked cells."""
        h = self.cell
        return np.repeat(np.repeat(cells, h, 0), h, 1)[: self.shape[0], : self.shape[1]]

    def nodes_of(self, cells: Bools) -> Bools:
        """Return which nodes (R, C) are corners of marked cells."""
        used = np.zeros(self.nodes, bool)
        for dy in (0, 1):
            for dx in (0, 1):
                used[dy : dy + self.cells[0], dx : dx + self.cells[1]] |= cells
        return used

    def areas(self, values: Floats, cells: Bools) -> Floats:
        """Return twice the signed area (K, 2) of both triangles of each marked cell under a map (R, C, 2)."""
        return areas(values, self.corners[cells])

    def bending(self, used: Bools) -> "scipy.sparse.csr_array":
        """Return the second differences among used nodes, L of NRT eq. 8: one row each, a column for every node."""
        box = around(used)
        straight = np.array([1.0, -2.0, 1.0])
        rows = (straight, straight, np.array([1.0, -1.0, -1.0, 1.0]) * np.sqrt(2))
        numbers = differing(np.arange(used.size).reshape(self.nodes)[box])
        columns: list[Ints] = []
        for nodes, marks in zip(numbers, differing(used[box]), strict=True):
            kept = np.logical_and.reduce(marks)
            columns.append(np.stack([corner[kept] for corner in nodes], -1))
        values = np.concatenate([np.tile(weights, len(nodes)) for nodes, weights in zip(columns, rows, strict=True)])
        widths = np.concatenate([np.full(*nodes.shape) for nodes in columns])
        ends, all_columns = np.append(0, np.cumsum(widths)), np.concatenate([nodes.ravel() for nodes in columns])
        return scipy.sparse.csr_array((values, all_columns, ends), shape=(len(widths), used.size))


def differing(grid: NDArray[Any]) -> Iterator[tuple[NDArray[Any], ...]]:
    """Yield what the second differences of a grid (R, C) are taken of: along rows, along columns, and across."""
    yield grid[:, :-2], grid[:, 1:-1], grid[:, 2:]
    yield grid[:-2], grid[1:-1], grid[2:]
    yield grid[:-1, :-1], grid[:-1, 1:], grid[1:, :-1], grid[1:, 1:]


def areas(values: Floats, corners: Ints) -> Floats:
    """Return what `ClothMesh.areas` does for the `corners` (K, 4) of the cells."""
    x, y = (values[..., k].ravel()[corners.T] for k in (0, 1))
    (_, right, left, across), (_, right_y, left_y, across_y) = (plane - plane[0] for plane in (x, y))
    return np.stack([right * across_y - right_y * across, across * left_y - across_y * left], -1)


def around(used: Bools, margin: int = 0) -> Box:
    """Return the rows and columns that a mask has marks in, and `margin` more on each side."""
    spans = []
    for axis in (1, 0):
        marked = np.flatnonzero(used.any(axis))
        first, last = (marked[0], marked[-1]) if len(marked) else (0, -1)
        spans.append(slice(max(int(first) - margin, 0), int(last) + 1 + margin))
    return spans[0], spans[1]


def boxes_of(used: Bools, margin: int) -> list[Box]:
    """Return boxes of a mask (H, W) that together hold all its marks and what is within a margin of them.

    They are of parts that lie apart, unless one around all has no more pixels.
    """
    everything = around(used, margin)
    near = cv2.dilate(used[everything].astype(np.uint8), np.ones((2 * margin + 1,) * 2, np.uint8))
    left, top, width, height, _ = cv2.connectedComponentsWithStats(near)[2][1:].T
    if (width * height).sum() >= near.size:
        return [everything]
    left, top = left + everything[1].start, top + everything[0].start
    return [(slice(y, y + h), slice(x, x + w)) for x, y, w, h in zip(left, top, width, height, strict=True)]


def nodes_in(box: Box) -> Box:
    """Return the rows and columns of the nodes of a box of cells."""
    return slice(box[0].start, box[0].stop + 1), slice(box[1].start, box[1].stop + 1)


def cross(a: Floats, b: Floats) -> Floats:
    """Return the z component of the product of plane vectors (..., 2)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
