"""A mesh of cells small beside folds: what was found on cells of a quarter of a lattice step is registered on it.

Second differences weigh by the length within which cloth bends, whatever the cells, so that finer ones are as smooth
as before where the photo says no more.
"""

from dataclasses import replace

import numpy as np

from core.arrays import Bools
from core.overlay.mesh import ClothMesh
from core.overlay.registration.cloth import Fit, FittedCloth, register_on
from core.overlay.registration.coarse_mesh import at_finer_nodes
from core.overlay.registration.region import continue_on, ring
from core.overlay.registration.registration import LEAST_SHADING, ClothState

CELL_PX = 3
"""Side of a cell."""
ROUNDS = 4
"""Steps of the registration."""
BESIDE = 2
"""Nodes beside a place that its cubic convolution looks at."""


def register_finely(cloth: FittedCloth, found: Fit) -> tuple[FittedCloth, Fit]:
    """Return a cloth and its fit on cells of `CELL_PX`, if its own are larger, registered with the texel it has."""
    if cloth.mesh.cell <= CELL_PX:
        return cloth, found
    mesh = ClothMesh(cloth.mesh.shape, CELL_PX)
    weight = cloth.canvas.valid[..., 0].astype(np.float64)
    fine = replace(cloth, mesh=mesh, registration=register_on(mesh, cloth.photo, weight, cloth.lattice, cloth.M))
    starts = [resample(cloth.mesh, piece, mesh) for piece in found.pieces]
    pieces = [fine.registration.run(start, found.texel, rounds=ROUNDS) for start in starts if start.cells.any()]
    return (fine, replace(found, pieces=tuple(pieces))) if len(pieces) == len(starts) else (cloth, found)


def resample(mesh: ClothMesh, state: ClothState, finer: ClothMesh) -> ClothState:
    """Return a state on a finer mesh, by cubic convolution; of a cell in use most lies in one that was."""
    around = ring(state.cells, np.ones_like(state.cells), BESIDE)
    values = continue_on(mesh, state, np.asarray(state.cells | around, np.bool_)).values
    values = at_finer_nodes(values, finer.nodes, mesh.cell / finer.cell)
    cells: Bools = np.asarray(finer.cell_means(mesh.pixels_of(state.cells).astype(float)) > 0.5, np.bool_)
    return ClothState(values[..., :2], np.maximum(values[..., 2], LEAST_SHADING), cells)
