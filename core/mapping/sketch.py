"""Nearly what handles do to a grid, on fewer nodes: for a frame in which they are at places not seen before."""

import numpy as np

from core.arrays import Floats, Ints, Points
from core.blas import one_thread
from core.grid import Grid
from core.mapping.editing import Editing, Frame
from core.mapping.handles import Handles

_NODES = 2500
"""About so many are edited: a response to a handle then takes some tenths of a millisecond."""
_TIMES_FEWER = 4
"""Grids with less than so many times as many nodes are not worth a sketch."""


class Sketch:
    """An editing of `grid` by way of larger cells; their displacements are interpolated by cubics.

    Handles come to lie within a pixel or so of their targets. The frame is that of `Editing`.
    """

    def __init__(self, grid: Grid, *, frame: Frame) -> None:
        self.grid, self.frame = grid, frame
        cell = float(np.sqrt(grid.cell[0] * grid.cell[1] * grid.size / _NODES))
        coarse = Grid(grid.width_px, grid.height_px, cell_px=cell)
        self._editing = Editing(coarse, frame=frame)
        self._nodes, self._weights = grid.weights_at(coarse.nodes.reshape(-1, 2))
        self._down, self._across = (_between(n, m) for n, m in zip(grid.shape, coarse.shape, strict=True))

    def solve(self, handles: Handles, base: Points) -> Points:
        """Return about where the nodes (R, C, 2) go that `base` (R, C, 2) places without handles."""
        coarse = self._editing.grid
        at, to = handles.points(coarse)
        start = self._at_coarse_nodes(base)
        with one_thread():
            self._editing.hold(at)
            away = self._editing.solve(to, start) - start
            fine = [self._down @ away[..., axis] @ self._across.T for axis in (0, 1)]
        return base + np.stack(fine, axis=-1)

    def _at_coarse_nodes(self, base: Points) -> Points:
        found: Points = (base.reshape(-1, 2)[self._nodes] * self._weights[..., None]).sum(axis=1)
        return found.reshape(*self._editing.grid.shape, 2)


def worth_sketching(grid: Grid) -> bool:
    """Return whether `grid` has so many nodes that a sketch saves time."""
    return grid.size >= _TIMES_FEWER * _NODES


def _between(count: int, coarse: int) -> Floats:
    """Return the weights (count, coarse) of cubic convolution from evenly spaced nodes to others on the same length.

    Beyond its ends what is interpolated goes on straight.
    """
    place = np.linspace(0, coarse - 1, count)
    first: Ints = np.minimum(place.astype(np.int64), coarse - 2)
    t = place - first
    weights = np.stack(
        [
            ((-0.5 * t + 1) * t - 0.5) * t,
            (1.5 * t - 2.5) * t * t + 1,
            ((-1.5 * t + 2) * t + 0.5) * t,
            (0.5 * t - 0.5) * t * t,
        ],
        axis=1,
    )
    wide = np.zeros((count, coarse + 2))
    np.put_along_axis(wide, first[:, None] + np.arange(4), weights, axis=1)
    for beyond, inner, step in ((0, 1, 1), (-1, -2, -1)):
        wide[:, inner] += 2 * wide[:, beyond]
        wide[:, inner + step] -= wide[:, beyond]
    return wide[:, 1:-1]
