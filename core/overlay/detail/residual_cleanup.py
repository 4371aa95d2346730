"""What the detail keeps of the old pattern, which would shine through another one.

The detail HF = I - ρ T(uv) holds the folds and the grain of the cloth, and what the model misses of the photo. That
is, first, what recurs at the same place of the texels around: in other light the pattern has another contrast. Second,
what a small shift and another sharpness leave; their amounts a and b hardly change over a neighbourhood:

    HF = ρ (a ∇T S⁻¹ + b (G * T - T)) + rest.

The rest has noise of the photo's compression, and is stronger at the edges of motifs than elsewhere: of its fine part
the grain of the cloth is kept. Its coarse part is the mean over a neighbourhood, mostly of the places where it is not
stronger than usual. Where a motif lies that the model does not have, there is no fine part, and where many do, none.
"""

import cv2
import numpy as np
import scipy

from core.arrays import Bools, Floats, Singles
from core.overlay.composition import finite
from core.overlay.detail.contrast import contrast_of
from core.overlay.detail.grain import COARSE_PX, DRAWN, NEAR_PX, even_out, grain_of
from core.overlay.detail.misplaced import find_misplaced
from core.overlay.detail.model_validity import estimate_trust
from core.overlay.filters.bands import bands
from core.overlay.filters.sampling import look_up
from core.overlay.filters.smoothing import gaussian, mean
from core.overlay.mesh import around
from core.overlay.texel import Texel, splat

AROUND = 1.5
"""Width, in texels, of the neighbourhood in which something recurs."""
MOST_SAMPLES = 1_000_000
"""Samples of the texture in which that is gathered."""
DOUBT = 3.0
"""Pixels at the same place below which it is half believed that something recurs there."""
SIGMA_PX = 2.0
"""Width of the neighbourhood with the same shift and sharpness."""
LEAST_NOISE = 0.003


def without_old_pattern(detail: Singles, uv: Singles, shading: Singles, texel: Texel, basis: Floats) -> Singles:
    """Return the detail (H, W, 3) of the cloth alone, to go with another texture.

    `uv` (H, W, 2), `shading` (H, W) or (H, W, 3) and `detail` are NaN outside the cloth; `basis` (2, 2) is pixels of
    undeformed cloth a texel.
    """
    covered = finite(uv)
    if not covered.any():
        return detail
    out, box = np.full_like(detail, np.nan), around(covered)
    out[box] = _without(detail[box], uv[box], shading[box], texel, basis)
    return out


def _without(detail: Singles, uv: Singles, shading: Singles, texel: Texel, basis: Floats) -> Singles:
    """Do what `without_old_pattern` does for a picture that has cloth up to all of its edges."""
    covered = finite(uv)
    noise = max(float(np.median(np.abs(detail[covered]))), LEAST_NOISE)
    rest = np.nan_to_num(detail)
    rest[covered] -= recurring(rest[covered], uv[covered], texel.shape, noise)
    faded = contrast_of(rest, uv, shading, texel, basis, noise)
    soft, before, other = texel.blurred(1.0, basis), rest.copy(), np.zeros(covered.shape, bool)
    for first, top, bottom, last in bands(len(rest), margin=int(6 * SIGMA_PX)):
        part, own = slice(first, last), slice(top - first, bottom - first)
        light, model, effects = modelled(uv[part], shading[part], texel, soft, basis)
        seen = before[part] - faded.within(model, covered[part], first)
        rest[top:bottom] = (seen - explain(seen, effects, covered[part], noise))[own]
        other[top:bottom] = find_misplaced(np.nan_to_num(detail[part]), model, light, texel, noise)[own]
    clear = covered & (cv2.dilate(other.astype(np.uint8), np.ones((3, 3), np.uint8)) == 0)
    side = float(np.sqrt(abs(np.linalg.det(basis))))
    held = estimate_trust(other, covered, side)
    grain, out = grain_of(rest, uv, clear, texel.shape, basis), before
    for first, top, bottom, last in bands(len(rest), margin=int(3 * (COARSE_PX + NEAR_PX))):
        part, own = slice(first, last), slice(top - first, bottom - first)
        out[top:bottom] = even_out(rest[part], uv[part], clear[part], held[part], grain)[own]
    out[~covered] = np.nan
    return out


def recurring(detail: Singles, uv: Singles, shape: tuple[int, int], noise: float) -> Singles:
    """Return what of the detail (n, C) at uv (n, 2) recurs at the same place of the texels around.

    `shape` (h, w) is that of the texel, `noise` how large a detail usually is.
    """
    low = np.floor(uv.min(0))
    texels = (np.floor(uv.max(0)) - low).astype(np.int64)[::-1] + 1
    share = min(1.0, float(np.sqrt(MOST_SAMPLES / (np.prod(texels) * np.prod(shape)))))
    h, w = (max(1, round(share * n)) for n in shape)
    rows, columns = int(texels[0]) * h, int(texels[1]) * w
    some = np.random.default_rng(0).random(len(uv), np.float32) < DRAWN / len(uv)
    index, shares = splat((uv[some].astype(np.float64) - low) / texels[::-1], (rows, columns))
    # A stain recurs nowhere: it must not be seen in its neighbours.
    values = (*np.clip(detail[some], -4 * noise, 4 * noise).T[..., None], 1.0)
    planes = [np.bincount(index.ravel(), (shares * value).ravel(), rows * columns) for value in values]
    by_texel: Singles = np.stack(planes, -1).astype(np.float32).reshape(int(texels[0]), h, int(texels[1]), -1)
    for axis in (0, 2):
        by_texel = scipy.ndimage.gaussian_filter1d(by_texel, AROUND, axis, mode="constant") * (
            AROUND * np.sqrt(2 * np.pi)
        )
    sums = by_texel.reshape(rows, columns, -1)
    # A pixel of the photo is several samples.
    mass = sums[..., -1:]
    means = sums[..., :-1] / (mass + DOUBT * some.sum() / max(int((mass > 0.1).sum()), 1))
    return look_up(means, (uv - low.astype(np.float32)) * np.array([w, h], np.float32) - np.float32(0.5))


def modelled(
    uv: Singles, shading: Singles, texel: Texel, soft: Texel, basis: Floats
) -> tuple[Singles, Singles, list[Singles]]:
    """Return ρ (H, W, 1 or 3), ρ T and what a shift right, a shift down and blur do to that, (H, W, 3) each."""
    at, to_uv = np.nan_to_num(uv).astype(np.float64), np.linalg.inv(basis).astype(np.float32)
    light = np.nan_to_num(shading)
    light = light if light.ndim == 3 else light[..., None]
    value, du, dv = texel.singles_with_gradient(at)
    right, down = (du * to_uv[0, k] + dv * to_uv[1, k] for k in (0, 1))
    softer = soft(at).astype(np.float32) - value
    return light, light * value, [light * effect for effect in (right, down, softer)]


def explain(detail: Singles, effects: list[Singles], covered: Bools, noise: float) -> Singles:
    """Return the part (H, W, 3) of the detail that the effects explain best over the neighbourhood of each pixel."""
    inside = covered.astype(np.float32)[..., None]
    fine = detail - mean(detail, inside, SIGMA_PX)
    slopes = [effect - mean(effect, inside, SIGMA_PX) for effect in effects]
    weight = inside[..., 0] * np.minimum(1, 3 * noise / np.maximum(np.sqrt(dot(fine, fine) / 3), 1e-9))
    count = len(slopes)
    pairs = [(i, j) for i in range(count) for j in range(i, count)]
    products = [dot(slopes[i], slopes[j]) * weight for i, j in pairs]
    products += [dot(slope, fine) * weight for slope in slopes]
    means = [gaussian(product, SIGMA_PX) for product in products]
    for k in range(count):
        means[pairs.index((k, k))] += noise**2
    amounts = solve_pixels(means[: len(pairs)], means[len(pairs) :])
    total = sum(amount[..., None] * effect for amount, effect in zip(amounts, effects, strict=True))
    return np.asarray(total * inside, np.float32)


def solve_pixels(rows: list[Singles], right: list[Singles]) -> list[Singles]:
    """Return the unknowns (H, W) of symmetric systems of three at every pixel: upper triangles by rows, right sides."""
    a, b, c, d, e, f = (plane.astype(np.float64) for plane in rows)
    minors = d * f - e * e, c * e - b * f, b * e - c * d, a * f - c * c, b * c - a * e, a * d - b * b
    det = a * minors[0] + b * minors[1] + c * minors[2]
    x, y, z = right
    order = ((0, 1, 2), (1, 3, 4), (2, 4, 5))
    return [((minors[i] * x + minors[j] * y + minors[k] * z) / det).astype(np.float32) for i, j, k in order]


def dot(a: Singles, b: Singles) -> Singles:
    """Return the sums (H, W) of products of the channels (H, W, 3)."""
    return np.asarray(np.einsum("...c,...c", a, b), np.float32)
