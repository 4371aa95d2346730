"""A deformed grid as a map of the plane, both ways.

`image` are pixels of the picture under the grid, `canvas` those of the result. Inside a quad with corners A, B, C, D,
clockwise from the top left, the map is bilinear in the place (u, v) within the cell:

    p(u, v) = A + u (B - A) + v (D - A) + u v (A - B + C - D)
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from core.arrays import Floats, Ints, Points, Singles
from core.grid import Grid
from core.rasters.raster import Box

Boxes: TypeAlias = tuple[Points, Points]
"""Low and high corners, (..., 2) each."""

BLOCK = 16
"""Quads along the side of a block; a point is looked for in blocks first."""
_NEWTON_STEPS = 8
_SLACK = 1e-6
"""How far outside its cell, in cells, a place may lie and still count as inside."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Where the nodes of `grid` are: `warped` (R, C, 2) in canvas pixels."""

    grid: Grid
    warped: Points

    def canvas_from_image(self, points: Points) -> Points:
        """Return canvas positions of picture positions (n, 2); outside the picture the nearest quad is continued."""
        points = np.asarray(points, np.float64)
        nodes, weights = self.grid.weights_at(points.reshape(-1, 2))
        found: Points = np.einsum("nk,nkc->nc", weights, self.warped.reshape(-1, 2)[nodes])
        return found.reshape(points.shape)

    def image_from_canvas(self, points: Points) -> Points:
        """Return picture positions of canvas positions (n, 2); NaN where the picture does not come.

        Where it comes several times, a fold, the upright sheet wins, and of those the one drawn last.
        """
        points = np.asarray(points, np.float64).reshape(-1, 2)
        result = np.full(points.shape, np.nan)
        which, quad = self._candidates(points)
        u, v = self._cell_places(points[which], quad)
        inside = (np.minimum(u, v) >= -_SLACK) & (np.maximum(u, v) <= 1 + _SLACK)
        which, quad, u, v = which[inside], quad[inside], u[inside], v[inside]
        best = np.lexsort((quad, self._areas(quad) > 0))
        row, column = np.divmod(quad[best], self.grid.columns - 1)
        width, height = self.grid.cell
        result[which[best], 0] = (column + u[best]) * width - 0.5
        result[which[best], 1] = (row + v[best]) * height - 0.5
        return result

    def canvas_of_box(self, box: Box) -> Singles:
        """Return the canvas positions (2, h, w) of the pixels of `box`, x and y."""
        return self.canvas_of_crossings(np.arange(box[0], box[2]), np.arange(box[1], box[3]))

    def canvas_of_crossings(self, x: NDArray[Any], y: NDArray[Any]) -> Singles:
        """Return the canvas positions (2, h, w), x and y, of where columns at `x` (w,) and rows at `y` (h,) cross.

        Outside the picture the nearest quad is continued.
        """
        rows, down = self._shares(y, axis=1)
        columns, across = self._shares(x, axis=0)
        return np.asarray(down @ self._singles[:, rows, columns] @ across.T, np.float32)

    def nodes_of_box(self, box: Box) -> Points:
        """Return the canvas positions (n, 2) of the nodes whose quads cover the pixels of `box`."""
        return self._patch(box).reshape(-1, 2)

    def most_stretch(self, box: Box) -> float:
        """Return by how much the sides of the quads that cover the pixels of `box` are longer than in the picture."""
        nodes = self._patch(box)
        return max(
            float(np.sqrt(((np.diff(nodes, axis=1 - axis) / self.grid.cell[axis]) ** 2).sum(axis=-1).max()))
            for axis in (0, 1)
        )

    def _patch(self, box: Box) -> Points:
        """Return the canvas positions (r, c, 2) of the nodes whose quads cover the pixels of `box`."""
        left, right = (self._cell_of(pixel, axis=0) for pixel in (box[0], box[2] - 1))
        top, bottom = (self._cell_of(pixel, axis=1) for pixel in (box[1], box[3] - 1))
        return self.warped[top : bottom + 2, left : right + 2]

    def box_near(self, low: Points, high: Points) -> Box | None:
        """Return the pixels of the quads that come into the canvas rectangle `low` to `high`; None if none does."""
        blocks = _meeting(self._block_boxes, low, high)
        if blocks is None:
            return None
        top, left, bottom, right = (BLOCK * number for number in blocks)
        quads = _meeting([side[top:bottom, left:right] for side in self._quad_boxes], low, high)
        if quads is None:
            return None
        width, height = self.grid.cell
        return (
            max(int(np.floor((left + quads[1]) * width)), 0),
            max(int(np.floor((top + quads[0]) * height)), 0),
            min(int(np.ceil((left + quads[3]) * width)) + 1, self.grid.width_px),
            min(int(np.ceil((top + quads[2]) * height)) + 1, self.grid.height_px),
        )

    @cached_property
    def bounds(self) -> tuple[Points, Points]:
        """Least and greatest canvas position (2,) of all nodes."""
        return find_bounds(self.warped)

    @cached_property
    def _singles(self) -> Singles:
        """Where the nodes are (2, R, C), x and y."""
        return np.ascontiguousarray(np.moveaxis(self.warped, -1, 0), np.float32)

    @cached_property
    def _quad_boxes(self) -> Boxes:
        """Boxes of all quads (R - 1, C - 1, 2)."""
        return _pairwise(np.minimum, self.warped), _pairwise(np.maximum, self.warped)

    @cached_property
    def _block_boxes(self) -> Boxes:
        """Boxes of the blocks of quads."""
        low, high = self._quad_boxes
        rows, columns = np.arange(0, low.shape[0], BLOCK), np.arange(0, low.shape[1], BLOCK)
        least = np.minimum.reduceat(np.minimum.reduceat(low, rows, axis=0), columns, axis=1)
        most = np.maximum.reduceat(np.maximum.reduceat(high, rows, axis=0), columns, axis=1)
        return least, most

    def _cell_of(self, pixel: int, *, axis: int) -> int:
        """Return the cell of a pixel column (`axis` 0) or row (1)."""
        return min(max(int((pixel + 0.5) / self.grid.cell[axis]), 0), self.grid.shape[1 - axis] - 2)

    def _shares(self, places: NDArray[Any], *, axis: int) -> tuple[slice, Singles]:
        """Return the nodes around columns (`axis` 0) or rows (1) of the picture, and the share (n, k) of each."""
        place = (places + 0.5) / self.grid.cell[axis]
        cell = np.clip(place.astype(np.int64), 0, self.grid.shape[1 - axis] - 2)
        nodes = slice(int(cell[0]), int(cell[-1]) + 2)
        number, share, inner = np.arange(len(cell)), place - cell, cell - nodes.start
        matrix = np.zeros((len(cell), nodes.stop - nodes.start), np.float32)
        matrix[number, inner], matrix[number, inner + 1] = 1 - share, share
        return nodes, matrix

    def _candidates(self, points: Points) -> tuple[Ints, Ints]:
        """Return pairs of a point's and a quad's number, the quad's box around the point; few to a point."""
        low, high = self._block_boxes
        held = ((low <= points[:, None, None]) & (points[:, None, None] <= high)).all(axis=-1)
        which, block_row, block_column = np.nonzero(held)
        inner = np.arange(BLOCK)
        row = (block_row * BLOCK)[:, None, None] + inner[:, None]
        column = (block_column * BLOCK)[:, None, None] + inner
        row, column = np.minimum(row, self.grid.rows - 2), np.minimum(column, self.grid.columns - 2)
        quad = (row * (self.grid.columns - 1) + column).reshape(-1, BLOCK * BLOCK)
        lows, highs = (side.reshape(-1, 2) for side in self._quad_boxes)
        target = points[which][:, None]
        hit = ((lows[quad] <= target) & (target <= highs[quad])).all(axis=-1)
        return np.repeat(which, hit.sum(axis=1)), quad[hit]

    def _corners(self, quad: Ints) -> Points:
        """Return the canvas positions (4, n, 2) of the corners of quads."""
        row, column = np.divmod(quad, self.grid.columns - 1)
        corners = [(row, column), (row, column + 1), (row + 1, column + 1), (row + 1, column)]
        return np.stack([self.warped[corner] for corner in corners])

    def _areas(self, quad: Ints) -> Floats:
        A, B, C, D = self._corners(quad)
        return _cross(C - A, D - B) / 2

    def _cell_places(self, points: Points, quad: Ints) -> tuple[Floats, Floats]:
        """Return (u, v) of `points` (n, 2) within their quads, by Newton's method on the bilinear map."""
        A, B, C, D = self._corners(quad)
        across, down, twist = B - A, D - A, A - B + C - D
        u, v = np.full(len(quad), 0.5), np.full(len(quad), 0.5)
        for _ in range(_NEWTON_STEPS):
            gap = points - (A + u[:, None] * across + v[:, None] * down + (u * v)[:, None] * twist)
            by_u, by_v = across + v[:, None] * twist, down + u[:, None] * twist
            area = _cross(by_u, by_v)
            area = np.where(np.abs(area) < np.finfo(float).tiny, np.inf, area)
            u = np.clip(u + _cross(gap, by_v) / area, -1, 2)
            v = np.clip(v + _cross(by_u, gap) / area, -1, 2)
        gap = points - (A + u[:, None] * across + v[:, None] * down + (u * v)[:, None] * twist)
        extent = np.abs(C - A).max(axis=-1) + np.abs(D - B).max(axis=-1)
        u[np.abs(gap).max(axis=-1) > _SLACK * np.maximum(extent, 1e-9)] = np.nan
        return u, v


def find_bounds(nodes: Points) -> tuple[Points, Points]:
    """Return least and greatest position (2,) of nodes (R, C, 2)."""
    # NumPy reduces pairs one by one, and rows of them as wholes.
    return nodes.min(axis=0).min(axis=0), nodes.max(axis=0).max(axis=0)


def _meeting(boxes: Sequence[Points], low: Points, high: Points) -> tuple[int, int, int, int] | None:
    """Return first row and column of the `boxes` that meet a rectangle, and those after the last; None if none does."""
    hit = np.all((boxes[0] <= high) & (boxes[1] >= low), axis=-1)
    rows, columns = np.flatnonzero(hit.any(axis=1)), np.flatnonzero(hit.any(axis=0))
    if not len(rows):
        return None
    return int(rows[0]), int(columns[0]), int(rows[-1]) + 1, int(columns[-1]) + 1


def _pairwise(choose: Callable[..., Floats], nodes: Points) -> Points:
    """Return `choose` over the four corners of every quad."""
    across = choose(nodes[:, :-1], nodes[:, 1:])
    return choose(across[:-1], across[1:])


def _cross(a: Points, b: Points) -> Floats:
    """Return the z component of a x b."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
