"""How far the model can be trusted: where the photo has other motifs, or nothing was followed, it lies beside it."""

import numpy as np

from core.arrays import Bools, Singles
from core.overlay.detail.misplaced import find_misplaced
from core.overlay.filters.distances import distance
from core.overlay.filters.smoothing import gaussian
from core.overlay.texel import Texel
from core.overlay.tolerances import LEAST_NOISE

AROUND = 0.2
"""Width of the neighbourhood that tells whether the model lies elsewhere, over the side of a texel."""
TRUSTED = (0.1, 0.3)
"""Share of a neighbourhood with other motifs than the model's, and distance from cloth that is followed, over the side
of a texel, up to which the model is trusted, and from which it is not."""


def estimate_trust(other: Bools, covered: Bools, side_px: float) -> Singles:
    """Return how far (H, W) the model is trusted, 0 to 1, where the photo has `other` motifs (H, W) than it."""
    sigma = AROUND * side_px
    mass = np.maximum(gaussian(covered.astype(np.float32), sigma), 1e-3)
    return falling(gaussian(other.astype(np.float32), sigma) / mass, TRUSTED)


def trust_in(photo: Singles, uv: Singles, shading: Singles, texel: Texel, followed: Bools, side_px: float) -> Singles:
    """Return how far (H, W) a model of the photo (H, W, 3) is trusted; only what is `followed` has been registered.

    `uv` (H, W, 2) and `shading` (H, W) are NaN outside the cloth.
    """
    covered, light = np.isfinite(shading), np.nan_to_num(shading)[..., None]
    model = light * texel(np.nan_to_num(uv).astype(np.float64)).astype(np.float32)
    detail = np.where(covered[..., None], photo - model, np.float32(0))
    noise = float(np.median(np.abs(detail[followed]))) if followed.any() else 0.0
    other = np.asarray(covered & find_misplaced(detail, model, light, texel, max(noise, LEAST_NOISE)), np.bool_)
    return np.minimum(estimate_trust(other, covered, side_px), falling(distance(followed) / side_px, TRUSTED))


def falling(values: Singles, between: tuple[float, float]) -> Singles:
    """Return 1 for values up to the first of two, 0 from the second one on."""
    return np.asarray(np.clip((between[1] - values) / (between[1] - between[0]), 0, 1), np.float32)
