"""The growth of a registered mesh until the cloth ends (NRT sec. 3.2)."""

from dataclasses import replace

import numpy as np

from core.arrays import Bools
from core.overlay.registration.cloth import Fit, FittedCloth, fitting_cells
from core.overlay.registration.region import LIMIT, continue_on, ring, without_specks
from core.overlay.registration.registration import ClothState
from core.overlay.tolerances import SMOOTH_PX
from core.progress import Job, Progress

COARSE = 0.08
"""Blur, in lattice steps, under which new cells are registered first: they may be off by a part of a motif."""
PRUNED = 0.6
"""Misfit, over the limit, from which a cell is registered again from its neighbours."""


def prune(cloth: FittedCloth, found: Fit) -> Fit:
    """Return the fit without the cells of its last piece that fit badly, which following may reach another way."""
    state = found.pieces[-1]
    good = without_specks(fitting_cells(cloth, state, found, limit=PRUNED * LIMIT), 4)
    return replace(found, pieces=(*found.pieces[:-1], replace(state, cells=good))) if good.any() else found


def followed(cloth: FittedCloth, found: Fit, step: Progress) -> Job[Fit]:
    """Return the fit with its last piece grown to where the misfit is the limit (NRT sec. 3.2: the cloth ends)."""
    state = found.pieces[-1]
    free_cells = cloth.allowed & ~(found.cells & ~state.cells)
    refused = np.zeros(state.cells.shape, np.int64)
    width = max(1, round(0.8 * cloth.step_px / cloth.mesh.cell))
    known = {state.cells.tobytes()}
    for _ in range(60):
        trial = ring(state.cells, free_cells & (refused < 2), width)
        if not trial.any():
            break
        before = state
        state = widen(cloth, state, trial, found)
        refused += trial & ~state.cells
        yield Progress(step.fraction, step.note)
        # Cells that are taken and given up by turns lead no further.
        if (state.cells & ~before.cells).sum() < 3 or state.cells.tobytes() in known:
            break
        known.add(state.cells.tobytes())
    return replace(found, pieces=(*found.pieces[:-1], state))


def widen(cloth: FittedCloth, state: ClothState, trial: Bools, found: Fit) -> ClothState:
    """Return the state with those of the trial cells that the texture explains once they are registered.

    Only the trial cells move; a band of old ones holds them, and is judged with them.
    """
    wider = continue_on(cloth.mesh, state, state.cells | trial)
    free = cloth.mesh.nodes_of(trial)
    moved = replace(wider, cells=trial | ring(trial, state.cells, 2))
    for blur_px in (COARSE * cloth.step_px, SMOOTH_PX):
        moved = cloth.registration.run(moved, found.texel, rounds=2, blur_px=blur_px, free=free)
    band = trial | ring(trial, state.cells, 4)
    wider = replace(wider, uv=moved.uv, rho=moved.rho)
    kept = fitting_cells(cloth, replace(wider, cells=band), found, limit=LIMIT)
    return replace(wider, cells=without_specks((state.cells & ~band) | kept, 4))
