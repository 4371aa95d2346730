"""Registration of single pixels, where the mesh is too coarse: what it misses would show as edges in the detail.

With r = I - ρ T(uv), and g = ρ ∇T S⁻¹ the slopes of the model by the place m = S uv in the undeformed cloth, a pixel
moves by the shift that fits best over its neighbourhood, held back by the noise (Lucas and Kanade, regularised):

    δ = (G * w g gᵀ + κ)⁻¹ (G * w g r).

It is smooth and less than a pixel, so that straight lines stay straight to the eye.
"""

from typing import TypeVar

import cv2
import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filters.bands import in_bands
from core.overlay.filters.smoothing import gaussian
from core.overlay.texel import Texel, draw_sample
from core.overlay.tolerances import LEAST_NOISE, NEARBY_PX, TYPICAL

Values = TypeVar("Values", Floats, Singles)

MOST_PX = 0.75
"""Longest shift."""
HOLD = 4.0
"""κ over the variance of the noise."""
ROUNDS = 3


def refine(
    photo: Floats | Singles, uv: Singles, shading: Singles, texel: Texel, basis: Floats, *, every: int = 1
) -> Singles:
    """Return `uv` (H, W, 2) moved by at most `MOST_PX` to where the texel explains the photo (H, W, 3) best.

    `uv` and `shading` (H, W) are NaN outside the cloth; `basis` (2, 2) is pixels of undeformed cloth a texel. Only
    every so many pixels are looked at across and down, and lengths are in as many: a large photo is a small one, finer.
    """
    few = slice(None, None, every)
    shift = np.zeros((*uv[few, few].shape[:2], 2), np.float32)
    noise, margin = usual_error(photo, uv, shading, texel), ROUNDS * int(np.ceil(3 * NEARBY_PX))

    def find_shifts(first: int, top: int, bottom: int, last: int) -> None:
        part = (slice(every * first, every * last, every), few)
        moved = shifts(photo[part], uv[part], shading[part], texel, basis / every, noise)
        shift[top:bottom] = moved[top - first : bottom - first]

    in_bands(find_shifts, shift.shape, margin)
    if every > 1:
        size = shift.shape[1] * every, shift.shape[0] * every
        shift = cv2.resize(shift, size, interpolation=cv2.INTER_LINEAR)[: uv.shape[0], : uv.shape[1]]
    return np.asarray(uv + shift, np.float32)


def usual_error(photo: Floats | Singles, uv: Singles, shading: Singles, texel: Texel) -> float:
    """Return the median error of a pixel's colour, from some of the pixels."""
    some = draw_sample(np.isfinite(shading), TYPICAL)
    if not some.any():
        return LEAST_NOISE
    error = photo[some] - shading[some, None].astype(np.float64) * texel.at(uv[some].astype(np.float64))
    return max(float(np.median(magnitude(error))), LEAST_NOISE)


def shifts(photo: Floats | Singles, uv: Singles, shading: Singles, texel: Texel, basis: Floats, noise: float) -> Floats:
    """Return by how many texels (H, W, 2) each pixel moves, 0 outside the cloth."""
    inside, to_uv = np.isfinite(shading), np.linalg.inv(basis)
    light, start = np.nan_to_num(shading)[..., None], np.nan_to_num(uv.astype(np.float64))
    seen, across, down = photo.astype(np.float32, copy=False), *to_uv.T.astype(np.float32)
    shift = np.zeros_like(start)
    for _ in range(ROUNDS):
        value, du, dv = texel.singles_with_gradient(start + shift @ to_uv.T)
        slopes = [light * (du * u + dv * v) for u, v in (across, down)]
        shift += best_shift(seen - light * value, slopes[0], slopes[1], inside, noise)
        shift *= np.minimum(1, MOST_PX / np.maximum(np.hypot(shift[..., 0], shift[..., 1]), 1e-9))[..., None]
    return np.asarray(np.where(inside[..., None], shift @ to_uv.T, 0.0), np.float64)


def best_shift(error: Singles, across: Singles, down: Singles, inside: Bools, noise: float) -> Floats:
    """Return δ (H, W, 2) for errors r and slopes g along x and y, all (H, W, 3)."""
    weight = inside * np.minimum(1, np.float32(2 * noise) / np.maximum(magnitude(error), np.float32(1e-9)))
    pairs = ((across, across), (across, down), (down, down), (across, error), (down, error))
    sums = (np.einsum("hwc,hwc->hw", one, other) * weight for one, other in pairs)
    a, b, c, p, q = (gaussian(plane, NEARBY_PX).astype(np.float64) for plane in sums)
    a, c = a + HOLD * noise**2, c + HOLD * noise**2
    return np.asarray(np.stack([c * p - b * q, a * q - b * p], -1) / (a * c - b * b)[..., None], np.float64)


def magnitude(error: Values) -> Values:
    """Return the root of the mean over the channels of squared errors (..., 3)."""
    out: Values = np.sqrt(np.einsum("...c,...c->...", error, error) / error.shape[-1])
    return out
