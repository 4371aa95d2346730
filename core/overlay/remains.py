"""What the detail keeps of the old pattern, which would shine through another one.

The detail HF = I - ρ T(uv) holds the folds and the grain of the cloth, and at the edges of motifs what the model misses
of the photo. Part of that is what a small shift and another sharpness would leave; their amounts a and b hardly change
over a neighbourhood:

    HF = ρ (a ∇T S⁻¹ + b (G * T - T)) + rest.

The rest has noise of the photo's compression, and is stronger at the edges of motifs than elsewhere. How strong it is
at each place of the texel shows over all texels together. Where it is stronger than usual, the fine part of the rest is
weakened to the usual strength; the coarse part is its mean over a neighbourhood, mostly of the places where it is not.
"""

from dataclasses import dataclass

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.bands import bands
from core.overlay.composition import finite
from core.overlay.smoothing import gaussian
from core.overlay.texel import Texel, gathered, splat

SIGMA_PX = 2.0
"""Width of the neighbourhood with the same shift and sharpness."""
COARSE_PX = 4.0
"""Width of the neighbourhood whose mean is the coarse part."""
NEAR_PX = 1.5
"""Width of the neighbourhood in which the strength of the fine part is measured."""
USUAL = 0.3
"""Share of the cloth on which the fine part is no stronger than usual."""
ODD = 4.0
"""Times the usual variance from which the coarse part is taken from elsewhere."""
DRAWN = 1_500_000
"""Pixels from which the strength at the places of the texel is estimated."""
LEAST_NOISE, LEAST_VARIANCE = 0.003, 1e-8


@dataclass(frozen=True)
class Strength:
    """How strong the fine part of the detail is."""

    at: Texel
    """Variance of each channel at the places of the texel."""
    usual: Floats
    """(3,), the usual variance."""


def without_old_pattern(detail: Singles, uv: Singles, shading: Singles, texel: Texel, basis: Floats) -> Singles:
    """Return the detail (H, W, 3) of the cloth alone, to go with another texture.

    `uv` (H, W, 2), `shading` (H, W) or (H, W, 3) and `detail` are NaN outside the cloth; `basis` (2, 2) is pixels of
    undeformed cloth a texel.
    """
    covered = finite(uv)
    if not covered.any():
        return detail
    rest = np.nan_to_num(detail)
    soft = texel.blurred(1.0, basis)
    noise = max(float(np.median(np.abs(rest[covered]))), LEAST_NOISE)
    for first, top, bottom, last in bands(len(rest), margin=int(6 * SIGMA_PX)):
        part, own = slice(first, last), slice(top - first, bottom - first)
        effects = effects_of(uv[part], shading[part], texel, soft, basis)
        rest[top:bottom] -= explained(np.nan_to_num(detail[part]), effects, covered[part], noise)[own]
    strength = strength_of(rest, uv, covered, texel.size, basis)
    out = np.full_like(detail, np.nan)
    for first, top, bottom, last in bands(len(rest), margin=int(3 * (COARSE_PX + NEAR_PX))):
        part, own = slice(first, last), slice(top - first, bottom - first)
        out[top:bottom] = evened(rest[part], uv[part], covered[part], strength)[own]
    return np.where(covered[..., None], out, np.nan).astype(np.float32)


def effects_of(uv: Singles, shading: Singles, texel: Texel, soft: Texel, basis: Floats) -> list[Floats]:
    """Return what a shift right, a shift down and blur do to the model, (H, W, 3) each."""
    at, to_uv = np.nan_to_num(uv).astype(np.float64), np.linalg.inv(basis)
    light = np.nan_to_num(shading).astype(np.float64)
    light = light if light.ndim == 3 else light[..., None]
    value, du, dv = texel.with_gradient(at)
    right, down = (du * to_uv[0, k] + dv * to_uv[1, k] for k in (0, 1))
    return [light * effect for effect in (right, down, soft(at) - value)]


def explained(detail: Singles, effects: list[Floats], covered: Bools, noise: float) -> Floats:
    """Return the part (H, W, 3) of the detail that the effects explain best over the neighbourhood of each pixel."""
    inside = covered.astype(np.float32)[..., None]
    fine = detail - mean(detail, inside, SIGMA_PX)
    slopes = [effect - mean(effect, inside, SIGMA_PX) for effect in effects]
    weight = inside[..., 0] * np.minimum(1, 3 * noise / np.maximum(np.sqrt((fine**2).mean(-1)), 1e-9))
    count = len(slopes)
    pairs = [(i, j) for i in range(count) for j in range(i, count)]
    products = [(slopes[i] * slopes[j]).sum(-1) * weight for i, j in pairs]
    products += [(slope * fine).sum(-1) * weight for slope in slopes]
    means = [gaussian(product.astype(np.float32), SIGMA_PX).astype(np.float64) for product in products]
    A = np.empty((*covered.shape, count, count))
    for (i, j), entry in zip(pairs, means, strict=False):
        A[..., i, j] = A[..., j, i] = entry
    A += noise**2 * np.eye(count)
    amounts = np.linalg.solve(A, np.stack(means[len(pairs) :], -1)[..., None])
    return np.asarray((np.stack(effects, -1) @ amounts)[..., 0] * inside, np.float64)


def strength_of(detail: Singles, uv: Singles, covered: Bools, size: tuple[int, int], basis: Floats) -> Strength:
    """Return the strength of the fine part of the detail (H, W, 3) over the places of a texel of `size` (h, w)."""
    fine = detail - mean(detail, covered.astype(np.float32)[..., None], COARSE_PX)
    drawn = covered & (np.random.default_rng(0).random(covered.shape) < DRAWN / max(int(covered.sum()), 1))
    places, squares = uv[drawn].astype(np.float64), fine[drawn].astype(np.float64) ** 2
    # A stain or a fold is not the pattern's.
    squares = np.minimum(squares, np.percentile(squares, 97, axis=0))
    even = np.ones(len(places))
    found = Texel(gathered(*splat(places, size), squares, even, even, size)).blurred(0.7, basis)
    found = Texel(np.maximum(found.pixels, LEAST_VARIANCE))
    return Strength(found, np.asarray(np.percentile(found.at(places), 100 * USUAL, axis=0), np.float64))


def evened(detail: Singles, uv: Singles, covered: Bools, strength: Strength) -> Floats:
    """Return the detail (H, W, 3) with its fine part no stronger than usual where the pattern makes it stronger."""
    inside = covered.astype(np.float32)[..., None]
    excess = strength.at(np.nan_to_num(uv).astype(np.float64)) / strength.usual
    fine = detail - mean(detail, inside, COARSE_PX)
    here = gaussian((fine**2 * inside).astype(np.float32), NEAR_PX) / strength.usual
    weight = inside * np.minimum(1, 1 / excess) * np.minimum(1, ODD / np.maximum(here, 1e-9))
    coarse = mean(detail, weight, COARSE_PX)
    fine = detail - coarse
    here = gaussian((fine**2 * inside).astype(np.float32), NEAR_PX) / strength.usual
    stronger = np.maximum(excess, np.clip(excess / 2 - 1, 0, 1) * here)
    return np.asarray(coarse + fine / np.sqrt(np.maximum(stronger, 1)), np.float64)


def mean(values: Singles | Floats, weight: Singles | Floats, sigma_px: float) -> Singles:
    """Return the mean of values (H, W, C) over neighbourhoods, under weights (H, W, 1 or C)."""
    total = gaussian((values * weight).astype(np.float32), sigma_px)
    mass = gaussian(np.asarray(weight, np.float32), sigma_px).reshape(*weight.shape)
    return np.asarray(total / np.maximum(mass, 1e-4), np.float32)
