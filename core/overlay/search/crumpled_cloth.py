"""Cloth so crumpled that neither a lattice grows nor keypoints are alike: all of it is registered at once.

Even steps are laid on all that may be cloth, in a picture so small that a texel is some pixels wide: folds displace it
there by less than it can be pulled back. Of the lattices that the autocorrelation proposes those that explain most are
followed.
"""

from contextlib import suppress

import numpy as np

from core.arrays import Floats
from core.overlay.detection.alignment import FlatPicture, PatchFrames
from core.overlay.detection.autocorrelation import propose_bases
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError
from core.overlay.filters.shrinking import shrunk
from core.overlay.registration.cloth import Fit, FittedCloth, make_divided_cloth
from core.overlay.registration.evidence import Evidence, weigh
from core.overlay.registration.fitting import LEAST_EVENNESS, complete, evenness
from core.overlay.search.large_periods import NOTE, TRIED, register_coarsely
from core.progress import Job, Progress

TIMES = (2, 4, 8)
"""Times that the picture is shrunk: octaves of the side of a texel."""


def find_crumpled(photo: Floats, canvas: FlatPicture, seed: int) -> Job[tuple[FittedCloth, Fit, Evidence]]:
    """Return the cloth registered from even steps over all that may be cloth, and followed to its end.

    Raises `NoPatternError` where none of the likeliest steps leads to a credible fit, and where there are stripes only.
    """
    yield Progress(0.0, NOTE)
    laid = [lay_evenly(photo, canvas, basis) for basis in find_likely_steps(photo, canvas)]
    for number, start in enumerate(sorted(laid, key=lambda one: weigh(*one).explained, reverse=True)):
        yield Progress((number + 1) / (TRIED + 1), NOTE)
        if evenness(*start) < LEAST_EVENNESS:
            break
        with suppress(NoPatternError):
            cloth, found = yield from complete(*start, [], seed)
            weight = weigh(cloth, found)
            if weight.is_credible:
                return cloth, found, weight
    raise NoPatternError


def find_likely_steps(photo: Floats, canvas: FlatPicture) -> list[Floats]:
    """Return the vectors (2, 2), columns, pixels, that explain most of the shrunk photo (H, W, 3), `TRIED` at most."""
    told: list[tuple[float, Floats]] = []
    for times in TIMES:
        inside = shrunk(canvas.valid, times) > 0.5
        small = FlatPicture(shrunk(canvas.image, times).astype(np.float32), inside.astype(np.float32))
        for basis in propose_bases(small.image, np.asarray(inside[..., 0], np.bool_)):
            explained = weigh(*lay_evenly(shrunk(photo, times), small, basis)).explained
            told.append((explained * times**2, basis * times))
    likely = sorted((one for one in told if one[0] > 0), key=lambda one: -one[0])
    return [basis for _, basis in likely[:TRIED]]


def lay_evenly(photo: Floats, canvas: FlatPicture, basis: Floats) -> tuple[FittedCloth, Fit]:
    """Return the cloth of a photo (H, W, 3) registered from even steps of a `basis` (2, 2), pixels, on all of it."""
    middle = np.median(np.argwhere(canvas.valid[..., 0] > 0)[:, ::-1], axis=0)
    cloth = make_divided_cloth(
        photo, canvas, Lattice(np.zeros((1, 2), np.int64), PatchFrames(middle[None], basis[None], np.ones(1)))
    )
    uv = (cloth.mesh.positions() - middle) @ np.linalg.inv(basis).T
    return cloth, register_coarsely(cloth, uv, np.asarray(cloth.valid_shares > 0.5, np.bool_))
