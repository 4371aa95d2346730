"""The search for small texels in an enlarged photo: shifts by less than a pixel tell how a texel of few pixels repeats.

What is found there is registered there too, and carried to the photo's own pixels in the end.
"""

from dataclasses import replace

import numpy as np

from core.arrays import Bools, Floats
from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.correlation import SIDES_PX
from core.overlay.detection.seeding import NoPatternError, flat_canvas
from core.overlay.filters.magnifying import TIMES, enlarged, enlarged_mask
from core.overlay.mesh import ClothMesh
from core.overlay.registration.cloth import Fit, FittedCloth, estimate, measure
from core.overlay.registration.registration import Registration

MOST_PX = float(TIMES * SIDES_PX[0])
"""Side of a texel of an enlarged photo up to which it is looked for there: the least exemplar holds it in the photo."""


def magnified(photo: Floats, valid: Bools) -> tuple[Floats, FlatPicture]:
    """Return a photo (H, W, 3) `TIMES` as large, by cubic interpolation, and the canvas of what is `valid` (H, W)."""
    large = np.asarray(np.clip(enlarged(photo), 0, 1), np.float64)
    return large, flat_canvas(large, enlarged_mask(valid))


def restrict(
    cloth: FittedCloth, found: Fit, photo: Floats, canvas: FlatPicture, times: int = 1
) -> tuple[FittedCloth, Fit]:
    """Return the cloth of a photo `times` as large as that of the photo (H, W, 3), with the same nodes.

    What the `canvas` of the photo says is no cloth is left out. Raises `NoPatternError` where nothing remains.
    """
    mesh = ClothMesh(photo.shape[:2], cloth.mesh.cell // times)
    lattice = cloth.lattice.shrunk(times)
    registration = Registration(mesh, photo, canvas.valid[..., 0].astype(np.float64), lattice.basis @ cloth.M)
    small = replace(cloth, photo=photo, canvas=canvas, lattice=lattice, mesh=mesh, registration=registration)
    pieces = [replace(piece, cells=np.asarray(piece.cells & small.allowed, np.bool_)) for piece in found.pieces]
    # The last piece is the one that is followed on.
    kept = tuple(sorted((piece for piece in pieces if piece.cells.any()), key=lambda piece: int(piece.cells.sum())))
    if not kept:
        raise NoPatternError
    return small, measure(small, estimate(small, kept), kept)
