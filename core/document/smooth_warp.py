"""W at the nodes of a large grid while it moves: as on a coarser grid, refined, where that shows no difference."""

from concurrent.futures import ThreadPoolExecutor
from functools import cached_property

import numpy as np

from core.arrays import Bools, Floats, Ints, Points
from core.grid import DEFAULT_NODES_AT_MOST, Grid
from core.linalg.cubic_convolution import Complexes, CubicConvolution
from core.mapping.jacobians import as_complex, as_positions
from core.mapping.tolerances import SEEN_PX
from core.warps.warp import Warp, in_parts

_MISSED = 2 / 27
"""Share of the third difference of the four values that a cubic goes by, up to which it is off where the curvature of
what it follows jumps; where that is smooth it is off by a fifth of it."""
_OFF_PX = SEEN_PX / 2
_BESIDE = ThreadPoolExecutor(1, "warp")
"""Where W is worked out at the nodes that are exact, while the others are refined."""


class SmoothWarp:
    """Evaluates warps at the nodes of a grid (R, C): exactly where cubics are off, and within a cell of the outline.

    A preset is as smooth as the picture is large, but where it ends, as a swirl does, or turns many times.
    """

    def __init__(self, grid: Grid) -> None:
        self._grid, self._coarse = grid, grid.with_nodes(DEFAULT_NODES_AT_MOST)
        self._cubic = CubicConvolution(self._coarse.shape, grid.shape)

    def evaluate(self, warp: Warp) -> Points:
        """Return W at the nodes (R, C, 2)."""
        d = as_complex(in_parts(warp, self._coarse.nodes))
        is_off = _third_differences(d) > _OFF_PX / _MISSED
        if is_off.sum() > is_off.size / 2:
            return in_parts(warp, self._grid.nodes)
        exact = self._nodes_in(is_off) if is_off.any() else self._border
        there = _BESIDE.submit(in_parts, warp, self._grid.nodes.reshape(-1, 2)[exact])
        z = self._cubic.refine(d).ravel()
        z[exact] = as_complex(there.result())
        return as_positions(z.reshape(self._grid.shape))

    @cached_property
    def _border(self) -> Ints:
        """The nodes in the outermost coarse cells: there cubics have values on one side only."""
        rows, columns = self._coarse.shape
        return self._nodes_in(np.zeros((max(rows - 3, 0), max(columns - 3, 0)), bool))

    def _nodes_in(self, is_off: Bools) -> Ints:
        """Return the nodes in the inner coarse cells (r - 3, c - 3) that are off, and in the outermost ones."""
        cells = np.pad(is_off, 1, constant_values=True)
        row, column = (
            np.minimum(np.arange(fine) * (coarse - 1) // (fine - 1), coarse - 2)
            for fine, coarse in zip(self._grid.shape, self._coarse.shape, strict=True)
        )
        return np.flatnonzero(cells[:, column][row])  # whole rows are copied four times as fast as single values


def _third_differences(d: Complexes) -> Floats:
    """Return the sum of the third differences across and down of d (r, c) in all cells but the outermost (r-3, c-3)."""
    across, down = np.abs(np.diff(d[1:-1], 3, axis=1)), np.abs(np.diff(d[:, 1:-1], 3, axis=0))
    return np.asarray(np.maximum(across[:-1], across[1:]) + np.maximum(down[:, :-1], down[:, 1:]))
