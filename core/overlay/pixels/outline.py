"""The outline of the cloth, to the pixel.

What the registered texture explains is judged over neighbourhoods, and a region is painted by hand: both end a few
pixels beside the cloth. There a pixel belongs to the cloth if the photo is rather a shade of the model than like what
surrounds the cloth, by the likelihood of both:

    |I - s ρ T(uv)|² / σ² + 3 log σ²  <  Σ (I - μ)² / τ² + log τ²,

with ρ as it is further inside, s the best of a few shades, μ and τ the mean and spread of the surroundings nearby.
Where a motif has the colour of the surroundings that tells little: the outline is the cheapest one, along edges.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats
from core.overlay.filters.distances import distance, within
from core.overlay.filters.smoothing import gaussian
from core.overlay.palette import from_shades
from core.overlay.pixels.graph_cut import MOST, cut_out
from core.overlay.tolerances import NEARBY_PX, RIM_PX, SHADES, SMOOTH_PX

NOTCH = 0.6
"""Radius of notches in the outline that are closed, over the width of the rim."""
LEAST_SPREAD = 0.03
CLEARLY = 1.0
"""How much likelier a pixel beyond the rim must be cloth."""
SURELY = 12.0
"""Most that one pixel counts."""


def beside(photo: Floats, texture: Floats, rho: Floats, covered: Bools, width_px: float) -> Bools:
    """Return which covered pixels (H, W), at most `width_px` from the border, show the surroundings and not the cloth.

    `photo` and `texture`, which is T(uv), are (H, W, 3), `rho` (H, W).
    """
    near, doubt = doubts(photo, texture, rho, covered, width_px)
    if not near.any():
        return near
    speaks = np.where(near, doubt / SURELY, np.where(covered, -MOST, MOST))
    other = cut_out(photo, covered, speaks)
    outer = covered & ~from_outside(near & other, covered)
    return covered & ~without_notches(outer, round(NOTCH * width_px))


def beyond(
    photo: Floats, texture: Floats, rho: Floats, covered: Bools, further: Bools, width_px: float, rim_px: float
) -> Bools:
    """Return which further pixels (H, W), at most `width_px` beyond those that are covered, show the cloth.

    `texture` and `rho` are those of the cloth carried on; the outermost `rim_px` of what is covered need not be cloth.
    """
    near, doubt = doubts(photo, texture, rho, covered | further, width_px + rim_px)
    cloth = further & near & ~from_outside(near & (doubt > -CLEARLY), covered | further)
    joined = gaussian((covered | cloth).astype(np.float64), SMOOTH_PX) > 0.5
    _, labels = cv2.connectedComponents((covered | (joined & cloth)).astype(np.uint8), connectivity=4)
    return np.asarray(joined & cloth & np.isin(labels, np.unique(labels[covered])), np.bool_)


def doubts(photo: Floats, texture: Floats, rho: Floats, covered: Bools, width_px: float) -> tuple[Bools, Floats]:
    """Return which pixels (H, W) of the rim can be judged, and how much likelier they are surroundings than cloth."""
    depth = distance(~covered)
    band, core = covered & (depth <= width_px), covered & (depth > width_px)
    around = ~covered & (distance(covered) > RIM_PX)
    near = band & within(core, 3 * width_px) & within(around, max(4 * NEARBY_PX, 1.5 * width_px))
    if not near.any():
        return near, np.zeros(covered.shape)
    model = nearby(rho, core, width_px)[near][:, None] * texture[near]
    spread = max(float(np.median(np.abs(photo[core] - (rho[..., None] * texture)[core]))) * 1.5, LEAST_SPREAD)
    unlike = from_shades(photo[near], model, SHADES) ** 2 / spread**2 + 6 * np.log(spread)
    middle = nearby(photo, around, 2 * NEARBY_PX)
    away = (photo - middle) ** 2
    variance = nearby(away, around, 2 * NEARBY_PX)[near] + LEAST_SPREAD**2
    other = (away[near] / variance + np.log(variance)).sum(-1)
    doubt = np.zeros(covered.shape)
    doubt[near] = np.clip(unlike - other, -SURELY, SURELY)
    doubt[~covered] = SURELY
    return near, np.asarray(gaussian(doubt, SMOOTH_PX), np.float64)


def from_outside(candidates: Bools, covered: Bools) -> Bools:
    """Return the candidates (H, W) that are connected with what is not covered."""
    _, labels = cv2.connectedComponents((candidates | ~covered).astype(np.uint8), connectivity=4)
    return np.asarray(candidates & np.isin(labels, np.unique(labels[~covered])), np.bool_)


def without_notches(mask: Bools, radius_px: int) -> Bools:
    """Return a mask (H, W) with the notches filled that no disc of that radius fits into: motifs that an edge cuts."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius_px + 1, 2 * radius_px + 1))
    closed = cv2.morphologyEx(np.pad(mask, radius_px).astype(np.uint8), cv2.MORPH_CLOSE, disc)
    return np.asarray(closed[radius_px:-radius_px, radius_px:-radius_px] > 0, np.bool_)


def nearby(values: Floats, where: Bools, sigma_px: float) -> Floats:
    """Return the mean of values (H, W) or (H, W, C) over the marked pixels of a neighbourhood."""
    weight = where.astype(np.float64)
    spread = weight if values.ndim == 2 else weight[..., None]
    sums = gaussian(np.where(spread > 0, values, 0.0), sigma_px)
    mass = gaussian(weight, sigma_px)
    return np.asarray(sums / np.maximum(mass if values.ndim == 2 else mass[..., None], 1e-9), np.float64)
