"""A mesh of twice the cell, on the photo halved: what a blur leaves of both is found there with a quarter of the work.

The change of the coarse mesh is added to the fine one, so that what the fine one has of its own stays: the correction
of a multigrid method [Brandt 1977].
"""

import numpy as np

from core.arrays import Bools, Floats
from core.linalg.cubic_convolution import cubic_weights
from core.overlay.mesh import ClothMesh
from core.overlay.registration.region import continue_on
from core.overlay.registration.registration import LEAST_SHADING, ClothState


def coarsen(mesh: ClothMesh, state: ClothState) -> ClothState:
    """Return a state at every second node, with the cells that a cell in use lies in."""
    cells = halve_cells(state.cells)
    around = np.repeat(np.repeat(cells, 2, 0), 2, 1)[: state.cells.shape[0], : state.cells.shape[1]]
    wide = continue_on(mesh, state, np.asarray(around, np.bool_)).values
    # The last coarse node may lie one past the last fine one.
    beyond = [(0, n % 2) for n in state.cells.shape] + [(0, 0)]
    few = np.pad(wide, beyond, mode="reflect", reflect_type="odd")[::2, ::2]
    return ClothState(few[..., :2], np.maximum(few[..., 2], LEAST_SHADING), cells)


def halve_cells(cells: Bools) -> Bools:
    """Return which squares of two by two cells have one in use."""
    even = np.pad(cells, [(0, n % 2) for n in cells.shape])
    return np.asarray(even[::2, ::2] | even[1::2, ::2] | even[::2, 1::2] | even[1::2, 1::2], np.bool_)


def correct(state: ClothState, before: ClothState, after: ClothState) -> ClothState:
    """Return a state moved as its coarser one was, which is linear between the coarse nodes."""
    change = after.values - before.values
    for axis, count in enumerate(state.rho.shape):
        node = np.arange(count)
        change = (change.take(node // 2, axis) + change.take((node + 1) // 2, axis)) / 2
    uv: Floats = state.uv + change[..., :2]
    return ClothState(uv, np.maximum(state.rho + change[..., 2], LEAST_SHADING), state.cells)


def at_finer_nodes(values: Floats, nodes: tuple[int, int], every: float = 2.0) -> Floats:
    """Return what has values (R, C, K) at every so many of some `nodes` at all of them, by cubic convolution."""
    down, across = (
        cubic_weights(np.minimum(np.arange(n) / every, known - 1.0), known)
        for n, known in zip(nodes, values.shape, strict=False)
    )
    return np.stack([(across @ (down @ plane).T).T for plane in np.moveaxis(values, -1, 0)], -1)
