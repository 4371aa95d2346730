"""How much of the pattern the light has taken: it does where the lattice is not the pattern's.

A texel that is a fraction of the true one, or none of its own, is washed out; what it lacks of the pattern the shading
puts on, from texel to texel. Light on cloth changes more slowly, or less.
"""

import numpy as np

from core.overlay.cloth import Cloth, Fit
from core.overlay.registration import LEAST_SHADING
from core.overlay.seeding import LIGHT_PX
from core.overlay.smoothing import gaussian


def share_in_light(cloth: Cloth, found: Fit) -> float:
    """Return how much the light changes from place to place, over how much the texel's colours do."""
    varied, count, sigma = 0.0, 0, LIGHT_PX / cloth.mesh.cell
    for piece in found.pieces:
        inside = cloth.mesh.nodes_of(piece.cells)
        light = np.log(np.maximum(piece.rho, LEAST_SHADING)) * inside
        usual = gaussian(light, sigma) / np.maximum(gaussian(inside.astype(np.float64), sigma), 1e-6)
        varied += float(((light - usual)[inside] ** 2).sum())
        count += int(inside.sum())
    colours = found.texel.pixels
    contrast = float(np.sqrt(colours.var(axis=(0, 1)).mean())) / max(float(colours.mean()), 1e-6)
    return float(np.sqrt(varied / max(count, 1))) / max(contrast, 1e-6)
