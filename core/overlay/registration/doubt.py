"""How much of the pattern the light has taken: it does where the lattice is not the pattern's.

A texel that is a fraction of the true one, or none of its own, is washed out; what it lacks of the pattern the shading
puts on, from texel to texel. Light in folds changes more slowly, or less: what a Gaussian mean leaves of it is taken
out again and again, which ends waves longer than a few texels and hardly touches shorter ones.
"""

import numpy as np

from core.arrays import Bools, Floats
from core.overlay.detection.seeding import LIGHT_PX
from core.overlay.registration.cloth import Cloth, Fit
from core.overlay.registration.registration import LEAST_SHADING
from core.overlay.smoothing import gaussian

ROUNDS = 3
"""Times that the mean is taken out."""


def share_in_light(cloth: Cloth, found: Fit) -> float:
    """Return how much the light changes from texel to texel, over how much the texel's colours do."""
    varied, count, sigma = 0.0, 0, min(cloth.step_px, LIGHT_PX) / cloth.mesh.cell
    for piece in found.pieces:
        inside = cloth.mesh.nodes_of(piece.cells)
        quick = without_slow(np.log(np.maximum(piece.rho, LEAST_SHADING)), inside, sigma)
        varied += float((quick[inside] ** 2).sum())
        count += int(inside.sum())
    colours = found.texel.pixels
    contrast = float(np.sqrt(colours.var(axis=(0, 1)).mean())) / max(float(colours.mean()), 1e-6)
    return float(np.sqrt(varied / max(count, 1))) / max(contrast, 1e-6)


def without_slow(values: Floats, inside: Bools, sigma: float) -> Floats:
    """Return values (h, w) freed of changes slower than `sigma` nodes, 0 outside."""
    mass = np.maximum(gaussian(inside.astype(np.float64), sigma), 1e-6)
    for _ in range(ROUNDS):
        values = (values - gaussian(values * inside, sigma) / mass) * inside
    return values
