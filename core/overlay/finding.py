"""The cloth of a photo: registered from the lattice that is found, or from a few large texels.

Stripes of a tartan repeat more often than its sett, and a lattice of them may be found that is none of the cloth's.
Where there is reason to doubt it, and where there is no lattice, large texels are looked for.
"""

import numpy as np

from core.arrays import Floats
from core.overlay.detection.alignment import Canvas
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.seeding import NoPatternError, evidence, find_lattice
from core.overlay.detection.stages import Stage
from core.overlay.registration.cloth import Cloth, Fit
from core.overlay.registration.doubt import share_in_light
from core.overlay.registration.fitting import begun, completed
from core.overlay.wide import find_wide
from core.progress import Job, Progress, part

DOUBTFUL, WEAK = 0.2, 2.5
"""Share of the pattern in the light from which, and evidence of a lattice up to which, large texels are looked for."""
LEAST_WORTH = 0.05
"""Worth of large texels, over the area that may be cloth, to be taken in place of a doubtful lattice."""
FALSE = 0.4
"""The same, of followed cloth, from which its lattice is none."""


def find_cloth(
    photo: Floats, canvas: Canvas, seed: int, *, texel_px: float | None = None, start: Proposal | None = None
) -> Job[tuple[Cloth, Fit]]:
    """Return the registered cloth of a photo (H, W, 3).

    `texel_px` is the side of a texel where the user knows it; the search begins at `start` alone if it is given.
    Raises `NoPatternError` if there is no pattern.
    """
    first: tuple[Cloth, Fit] | None = None
    sure = start is not None
    try:
        search = find_lattice(canvas, np.random.default_rng(seed), texel_px=texel_px, start=start)
        lattice = yield from part(search, 0.0, 0.4)
        yield Progress(0.4, "registering", Stage("lattice", lattice, shape=canvas.shape))
        first = yield from part(begun(photo, canvas, lattice, seed), 0.4, 0.45)
        if sure or (share_in_light(*first) < DOUBTFUL and evidence(lattice) > WEAK):
            return (yield from part(completed(*first, [], seed, sure=sure), 0.45, 1.0))
    except NoPatternError:
        if sure:
            raise
        first = None
    try:
        least = 0.0 if first is None else LEAST_WORTH
        wide = find_wide(photo, canvas, np.random.default_rng(seed), texel_px=texel_px, least=least)
        cloth, found = yield from part(wide, 0.45, 0.6)
    except NoPatternError:
        if first is None:
            raise
        whole = yield from part(completed(*first, [], seed), 0.6, 1.0)
        if share_in_light(*whole) > FALSE:
            raise
        return whole
    return (yield from part(completed(cloth, found, [], seed, sure=True), 0.6, 1.0))
