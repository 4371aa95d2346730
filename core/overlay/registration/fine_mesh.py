"""A mesh of cells small beside folds: what was found on cells of a quarter of a lattice step is registered on it.

Its second differences weigh as much as a node's data, so that the cloth bends within about a cell.
"""

from dataclasses import replace

import numpy as np

from core.arrays import Bools
from core.overlay.mesh import ClothMesh
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.coarse_mesh import at_finer_nodes
from core.overlay.registration.normal_equations import Smoothness
from core.overlay.registration.region import continue_on, ring
from core.overlay.registration.registration import LEAST_SHADING, ClothState, Registration

SIDE = 0.2
"""Side of a cell in lattice steps: what folds within less shows no motif."""
SIDES_PX = (3, 5)
"""That side at least and at most: smaller cells hold too few pixels, and folds are no wider where texels are large."""
ROUNDS = 3
"""Steps of the registration."""
SMOOTHNESS = Smoothness(1.0, 1.0, by_mean=True)
BESIDE = 2
"""Nodes beside a place that its cubic convolution looks at."""


def register_finely(cloth: FittedCloth, found: Fit) -> tuple[FittedCloth, Fit]:
    """Return a cloth and its fit on smaller cells, unless its own are as small, registered with the texel it has."""
    cell = round(float(np.clip(SIDE * cloth.step_px, *SIDES_PX)))
    if cloth.mesh.cell <= cell:
        return cloth, found
    mesh, weight = ClothMesh(cloth.mesh.shape, cell), cloth.canvas.valid[..., 0].astype(np.float64)
    fine = replace(cloth, mesh=mesh, registration=Registration(mesh, cloth.photo, weight, cloth.basis, SMOOTHNESS))
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
