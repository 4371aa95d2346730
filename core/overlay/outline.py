"""The outline of the cloth, to the pixel.

What the registered texture explains is judged over neighbourhoods, and a region is painted by hand: both end a few
pixels beside the cloth. There a pixel belongs to the cloth if the photo is rather a shade of the model than like what
surrounds the cloth, by the likelihood of both:

    |I - s ρ T(uv)|² / σ² + 3 log σ²  <  Σ (I - μ)² / τ² + log τ²,

with ρ as it is further inside, s the best of a few shades, μ and τ the mean and spread of the surroundings nearby.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.palette import from_shades
from core.overlay.smoothing import gaussian

SHADES = (0.5, 1.25)
"""Light at the rim, over that further inside."""
SURROUNDINGS_PX = 6.0
"""Width of the neighbourhood that shows what surrounds the cloth."""
APART_PX = 1.5
"""Distance from what may be cloth from which surroundings are taken."""
SMOOTH_PX = 1.0
"""Width over which pixels are judged together."""
NOTCH = 0.6
"""Radius of notches in the outline that are closed, over the width of the rim."""
LEAST_SPREAD = 0.03
SURELY = 12.0
"""Most that one pixel counts."""


def beside(photo: Floats, texture: Floats, rho: Floats, covered: Bools, width_px: float) -> Bools:
    """Return which covered pixels (H, W), at most `width_px` from the border, show the surroundings and not the cloth.

    `photo` and `texture`, which is T(uv), are (H, W, 3), `rho` (H, W).
    """
    depth = distance(~covered)
    band, core = covered & (depth <= width_px), covered & (depth > width_px)
    around = ~covered & (distance(covered) > APART_PX)
    out = np.zeros(covered.shape, bool)
    near = band & (within(core, 3 * width_px) & within(around, 2 * SURROUNDINGS_PX))
    if not near.any():
        return out
    model = nearby(rho, core, width_px)[..., None] * texture
    spread = max(float(np.median(np.abs(photo[core] - (rho[..., None] * texture)[core]))) * 1.5, LEAST_SPREAD)
    unlike = from_shades(photo, model, SHADES) ** 2 / spread**2 + 6 * np.log(spread)
    middle = nearby(photo, around, SURROUNDINGS_PX)
    variance = nearby((photo - middle) ** 2, around, SURROUNDINGS_PX) + LEAST_SPREAD**2
    other = ((photo - middle) ** 2 / variance + np.log(variance)).sum(-1)
    doubt = np.where(near, np.clip(unlike - other, -SURELY, SURELY), 0.0)
    doubt[~covered] = SURELY
    doubt = gaussian(doubt, SMOOTH_PX)
    candidates = (near & (doubt > 0)) | ~covered
    _, labels = cv2.connectedComponents(candidates.astype(np.uint8), connectivity=4)
    outside = np.unique(labels[~covered])
    return covered & ~without_notches(
        covered & ~(near & candidates & np.isin(labels, outside)), round(NOTCH * width_px)
    )


def without_notches(mask: Bools, radius_px: int) -> Bools:
    """Return a mask (H, W) with the notches filled that no disc of that radius fits into: motifs that an edge cuts."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius_px + 1, 2 * radius_px + 1))
    closed = cv2.morphologyEx(np.pad(mask, radius_px).astype(np.uint8), cv2.MORPH_CLOSE, disc)
    return np.asarray(closed[radius_px:-radius_px, radius_px:-radius_px] > 0, np.bool_)


def distance(mask: Bools) -> Singles:
    """Return how far (H, W) pixels are from a mask."""
    return np.asarray(cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5), np.float32)


def within(mask: Bools, most_px: float) -> Bools:
    """Return the pixels (H, W) at most so far from a mask."""
    return np.asarray(distance(mask) <= most_px, np.bool_) if mask.any() else np.zeros(mask.shape, bool)


def nearby(values: Floats, where: Bools, sigma_px: float) -> Floats:
    """Return the mean of values (H, W) or (H, W, C) over the marked pixels of a neighbourhood."""
    weight = where.astype(np.float64)
    spread = weight if values.ndim == 2 else weight[..., None]
    sums = gaussian(np.where(spread > 0, values, 0.0), sigma_px)
    mass = gaussian(weight, sigma_px)
    return np.asarray(sums / np.maximum(mass if values.ndim == 2 else mass[..., None], 1e-9), np.float64)
