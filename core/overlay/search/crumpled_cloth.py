"""Cloth so crumpled that neither a lattice grows nor keypoints are alike: all of it is registered at once.

Even steps are laid on all that may be cloth, in a picture so small that a texel is some pixels wide: folds displace it
there by less than it can be pulled back. Of the lattices that the autocorrelation proposes those that explain most are
followed.
"""

from contextlib import suppress
from operator import itemgetter

import numpy as np

from core.arrays import Floats
from core.overlay.detection.alignment import FlatPicture, PatchFrames
from core.overlay.detection.autocorrelation import propose_bases
from core.overlay.detection.basis import is_about
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError
from core.overlay.filters.shrinking import shrunk
from core.overlay.registration.cloth import Fit, FittedCloth, make_divided_cloth
from core.overlay.registration.evidence import Evidence, weigh
from core.overlay.registration.fitting import LEAST_EVENNESS, complete, evenness
from core.overlay.search.large_periods import NOTE, TRIED, register_coarsely
from core.progress import Job, Progress, part

TIMES = (2, 4, 8)
"""Times that the picture is shrunk: octaves of the side of a texel."""


def find_crumpled(
    photo: Floats, canvas: FlatPicture, seed: int, *, texel_px: float | None = None
) -> Job[tuple[FittedCloth, Fit, Evidence]]:
    """Return the cloth registered from even steps over all that may be cloth, and followed to its end.

    `texel_px` is about the side of a texel where that is known. Raises `NoPatternError` where none of the likeliest
    steps leads to a credible fit, and where there are stripes only.
    """
    likely = yield from part(find_likely_steps(photo, canvas, texel_px), 0.0, 0.3)
    laid = yield from part(lay_each(photo, canvas, likely), 0.3, 0.4)
    for _, cloth, start in laid:
        if evenness(cloth, start) < LEAST_EVENNESS:
            break
        with suppress(NoPatternError):
            _, found = yield from part(complete(cloth, start, [], seed), 0.4, 1.0)
            weight = weigh(cloth, found)
            if weight.is_credible:
                return cloth, found, weight
    raise NoPatternError


def find_likely_steps(photo: Floats, canvas: FlatPicture, texel_px: float | None = None) -> Job[list[Floats]]:
    """Return the vectors (2, 2), columns, pixels, that explain most of the shrunk photo (H, W, 3), `TRIED` at most."""
    told: list[tuple[float, Floats]] = []
    for number, times in enumerate(TIMES):
        small, inside = shrunk(photo, times), shrunk(canvas.valid, times) > 0.5
        flat = FlatPicture(shrunk(canvas.image, times).astype(np.float32), inside.astype(np.float32))
        proposed = propose_bases(flat.image, np.asarray(inside[..., 0], np.bool_))
        bases = [basis for basis in proposed if is_about(times * basis, texel_px)]
        laid = yield from part(lay_each(small, flat, bases), number / len(TIMES), (number + 1) / len(TIMES))
        told += [(explained * times**2, cloth.basis * times) for explained, cloth, _ in laid if explained > 0]
    return [basis for _, basis in sorted(told, key=itemgetter(0), reverse=True)[:TRIED]]


def lay_each(photo: Floats, canvas: FlatPicture, bases: list[Floats]) -> Job[list[tuple[float, FittedCloth, Fit]]]:
    """Return what speaks for the cloth that is laid from each of the bases (2, 2), and that; the likeliest first."""
    laid: list[tuple[float, FittedCloth, Fit]] = []
    for number, basis in enumerate(bases):
        yield Progress(number / len(bases), NOTE)
        with suppress(NoPatternError):
            cloth, found = lay_evenly(photo, canvas, basis)
            laid.append((weigh(cloth, found).explained, cloth, found))
    return sorted(laid, key=itemgetter(0), reverse=True)


def lay_evenly(photo: Floats, canvas: FlatPicture, basis: Floats) -> tuple[FittedCloth, Fit]:
    """Return the cloth of a photo (H, W, 3) registered from even steps of a `basis` (2, 2), pixels, on all of it.

    Raises `NoPatternError` where what may be cloth fills no cell of the mesh.
    """
    middle = np.median(np.argwhere(canvas.valid[..., 0] > 0)[:, ::-1], axis=0)
    lattice = Lattice(np.zeros((1, 2), np.int64), PatchFrames(middle[None], basis[None], np.ones(1)))
    cloth = make_divided_cloth(photo, canvas, lattice)
    uv, cells = (cloth.mesh.positions() - middle) @ np.linalg.inv(basis).T, cloth.valid_shares > 0.5
    if not cells.any():
        raise NoPatternError
    return cloth, register_coarsely(cloth, uv, np.asarray(cells, np.bool_))
