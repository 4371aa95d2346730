"""How bright the texel is, and how strong the light: of the two only the product is seen."""

import numpy as np

from core.arrays import Floats, Singles

BRIGHTEST = 99.5
"""Per cent of the texel's samples that are to be no brighter than white."""


def gauge_of(shading: Floats | Singles, texel: Floats) -> float:
    """Return what to divide the texel (h, w, 3) and to multiply the shading (H, W), NaN outside the cloth, by.

    The usual light becomes 1, so that a new texture is as bright on the cloth as in its own file, as far as that leaves
    the texel within the white.
    """
    usual = float(np.nanmedian(shading)) if np.isfinite(shading).any() else 1.0
    return max(1 / max(usual, 1e-3), float(np.percentile(texel, BRIGHTEST)))
