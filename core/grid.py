"""The quad grid over a picture, and the features that a mask marks on it.

Nodes are numbered row by row from the top left. A quad's corners run clockwise from its top left; its diagonal goes
from top left to bottom right wherever quads are cut into triangles.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from core.arrays import Bools, Bytes, Floats, InputError, Ints, Points, readonly

DEFAULT_QUADS = 24_000
"""FAT sec. 4 keeps the system between 20 000 and 50 000 unknowns."""
DEFAULT_NODES_AT_MOST = 50_000
NODES_AT_MOST = 4_000_000
SIDES: list[Any] = [np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]]
"""Top, bottom, left and right side of what a grid has at its nodes."""


@dataclass(frozen=True)
class Grid:
    """A grid of R x C nodes over the whole area of a picture, cells as square as whole numbers allow.

    Raises `InputError` for a picture without pixels and for a cell that is not positive or makes the grid too large.
    """

    width_px: int
    height_px: int
    cell_px: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.width_px < 1 or self.height_px < 1:
            raise InputError(f"a picture of {self.width_px} x {self.height_px} pixels cannot be gridded")
        if self.cell_px is None:
            return
        if not (math.isfinite(self.cell_px) and self.cell_px > 0):
            raise InputError(f"grid cell of {self.cell_px:g} px: must be positive")
        if self.width_px / self.cell_px * self.height_px / self.cell_px > NODES_AT_MOST:
            raise InputError(f"grid cell of {self.cell_px:g} px: gives more than {NODES_AT_MOST} nodes")

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of nodes."""
        if self.cell_px is not None:
            return self._shape_at(self.cell_px)
        cell = max(1.0, math.sqrt(self.width_px * self.height_px / DEFAULT_QUADS))
        while math.prod(shape := self._shape_at(cell)) > DEFAULT_NODES_AT_MOST:
            cell *= 1.1
        return shape

    def _shape_at(self, cell_px: float) -> tuple[int, int]:
        return max(1, round(self.height_px / cell_px)) + 1, max(1, round(self.width_px / cell_px)) + 1

    @property
    def rows(self) -> int:
        """R, rows of nodes."""
        return self.shape[0]

    @property
    def columns(self) -> int:
        """C, columns of nodes."""
        return self.shape[1]

    @property
    def size(self) -> int:
        """N, the number of nodes."""
        return self.rows * self.columns

    @cached_property
    def cell(self) -> tuple[float, float]:
        """Width and height of a cell, in pixels."""
        return self.width_px / (self.columns - 1), self.height_px / (self.rows - 1)

    @property
    def cell_aspect(self) -> tuple[float, float]:
        """Width and height of a cell, in units of their mean."""
        width, height = self.cell
        unit = math.sqrt(width * height)
        return width / unit, height / unit

    @cached_property
    def nodes(self) -> Points:
        """Rest positions (R, C, 2) in pixels, from (-0.5, -0.5) to (W - 0.5, H - 0.5)."""
        x = np.linspace(-0.5, self.width_px - 0.5, self.columns)
        y = np.linspace(-0.5, self.height_px - 0.5, self.rows)
        return readonly(np.ascontiguousarray(np.stack(np.meshgrid(x, y), axis=-1)).copy())

    @cached_property
    def pixels(self) -> tuple[Ints, Ints]:
        """Rows and columns of the pixels that are nearest to the nodes."""
        row = np.clip(np.rint(self.nodes[:, 0, 1]), 0, self.height_px - 1).astype(np.int64)
        column = np.clip(np.rint(self.nodes[0, :, 0]), 0, self.width_px - 1).astype(np.int64)
        return row, column

    def coarsened(self, cells: float) -> "Grid":
        """Return a grid over the same picture whose cells are about `cells` times as long."""
        return Grid(self.width_px, self.height_px, cell_px=cells * math.sqrt(self.cell[0] * self.cell[1]))

    def with_nodes(self, most: int) -> "Grid":
        """Return a grid over the same picture of about so many nodes, where it has more."""
        return self.coarsened(max(1.0, math.sqrt(self.size / most)))

    @cached_property
    def quads(self) -> Ints:
        """Node numbers (M, 4) of each quad, clockwise from the top left."""
        number = np.arange(self.size).reshape(self.shape)
        corners = [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]]
        return readonly(np.stack(corners, axis=-1).reshape(-1, 4).copy())

    @cached_property
    def triangles(self) -> Ints:
        """Node numbers (2M, 3): each quad cut from its top left to its bottom right."""
        return readonly(self.quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3).copy())

    @cached_property
    def outline(self) -> Bools:
        """Which nodes (R, C) lie on the picture's edge."""
        edge = np.zeros(self.shape, bool)
        edge[[0, -1]] = True
        edge[:, [0, -1]] = True
        return readonly(edge)

    def weights_at(self, points: Points) -> tuple[Ints, Floats]:
        """Return the corner nodes (n, 4) of the quads that hold `points` (n, 2) and their bilinear weights (n, 4).

        A point outside the picture belongs to the nearest quad and has weights outside 0 to 1.
        """
        across, down = (points[:, axis] + 0.5 for axis in (0, 1))
        u, v = across / self.cell[0], down / self.cell[1]
        column = np.clip(np.floor(u), 0, self.columns - 2).astype(np.int64)
        row = np.clip(np.floor(v), 0, self.rows - 2).astype(np.int64)
        u, v = u - column, v - row
        corner = row * self.columns + column
        nodes = corner[:, None] + np.array([0, 1, self.columns + 1, self.columns])
        return nodes, np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=-1)

    def read(self, points: Points, values: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return what `values` (N,) or (N, q) at the nodes are at `points` (n, 2)."""
        nodes, weights = self.weights_at(points)
        return np.asarray(np.einsum("nk,nk...->n...", weights, values[nodes]))


@dataclass(frozen=True, eq=False)
class Features:
    """The 8-connected components of a mask, as they fall on the nodes of a grid."""

    labels: NDArray[np.int32]
    """Component number of every node (R, C), as `cv2.connectedComponents` numbers them; 0 outside features."""

    @cached_property
    def ids(self) -> Ints:
        """Numbers of the components that hold at least one node, ascending."""
        return readonly(np.flatnonzero(np.bincount(self.labels.ravel()))[self._skip :].copy())

    @property
    def _skip(self) -> int:
        return int((self.labels == 0).any())

    def __len__(self) -> int:
        return len(self.ids)

    def nodes_of(self, number: int) -> Ints:
        """Return the node numbers of component `number`, ascending."""
        return np.flatnonzero(self.labels == number)


def find_features(grid: Grid, mask: Bytes | None) -> Features:
    """Label the grid's nodes by the components of `mask` (H, W), where over 127 is a feature.

    A node is in a feature when the pixel nearest to it is. Raises `InputError` for a mask of another size.
    """
    if mask is None:
        return Features(readonly(np.zeros(grid.shape, np.int32)))
    if mask.shape != (grid.height_px, grid.width_px):
        found = " x ".join(str(n) for n in mask.shape[1::-1])
        raise InputError(f"mask of {found} pixels: the picture has {grid.width_px} x {grid.height_px}")
    # Only the painted part is searched. It begins at an even pixel, as the blocks do by which OpenCV numbers.
    left, top, width, height = cv2.boundingRect(mask)
    left, top, right, bottom = left & ~1, top & ~1, left + width, top + height
    painted = np.asarray(mask[top:bottom, left:right] > 127, np.uint8)
    row, column = grid.pixels
    rows, columns = np.flatnonzero((row >= top) & (row < bottom)), np.flatnonzero((column >= left) & (column < right))
    labels = np.zeros(grid.shape, np.int32)
    if painted.size:
        _, components = cv2.connectedComponents(painted, connectivity=8)
        labels[np.ix_(rows, columns)] = components[np.ix_(row[rows] - top, column[columns] - left)]
    return Features(readonly(labels))
