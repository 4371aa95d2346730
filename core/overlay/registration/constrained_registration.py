"""Registration of cloth that is carried on beyond what was followed: straight on, it soon lies beside the photo.

Only the pixels that have been found to be cloth count, so that neither the ground nor a hand pulls at the mesh, and
what was followed stays where it is.
"""

from dataclasses import replace

import numpy as np

from core.arrays import Bools
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.region import ring
from core.overlay.registration.region_growing import COARSE
from core.overlay.registration.registration import ClothState
from core.overlay.tolerances import SMOOTH_PX

ROUNDS = 4
"""Steps under each blur."""
FIRM = 3.0
"""Smoothness over the usual one of a border: it is held from one side only."""
HOLDING = 2
"""Width, in quarters of a lattice step, of the cloth that was followed and holds the rest."""


def settle(
    cloth: FittedCloth, found: Fit, piece: ClothState, wanted: Bools, covered: Bools, firm: float = 1.0
) -> ClothState:
    """Return a piece that has values at the nodes around wanted pixels (H, W) with these nodes registered.

    `covered` (H, W) is what was followed; the piece's cells stay. `firm` is its smoothness over the usual one.
    """
    trial = np.asarray((cloth.mesh.cell_means(wanted.astype(float)) > 0) & ~piece.cells, np.bool_)
    free = cloth.mesh.nodes_of(trial) & ~cloth.mesh.nodes_of(piece.cells)
    if not free.any():
        return piece
    registration = cloth.registration.weighted((wanted | covered).astype(np.float64))
    band = replace(piece, cells=trial | ring(trial, piece.cells, HOLDING * cloth.quarter_step))
    for blur_px in (COARSE * cloth.step_px, SMOOTH_PX):
        band = registration.run(band, found.texel, rounds=ROUNDS, blur_px=blur_px, free=free, firm=firm)
    return replace(band, cells=piece.cells)
