"""What the detail keeps of the old pattern, which would shine through another one.

What a photo has over the colours of the pattern holds the folds and the grain of the cloth, and what those colours miss
of it. That is, first, what recurs at the same place of the texels around: in other light the pattern has another
contrast. Second, what a small shift and another sharpness leave; their amounts a and b hardly change over a
neighbourhood:

    detail = ρ (a ∇T S⁻¹ + b (G * T - T)) + rest.

The rest has noise of the photo's compression, and is stronger at the edges of motifs than elsewhere: of its fine part
the grain of the cloth is kept. Its coarse part is the mean over a neighbourhood, mostly of the places where it is not
stronger than usual.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from core.arrays import Bools, Floats, Singles
from core.overlay.composition import finite
from core.overlay.detail.grain import even_out, grain_of
from core.overlay.filters.bands import PIXELS, in_bands
from core.overlay.filters.sampling import look_up
from core.overlay.filters.smoothing import gaussian, mean
from core.overlay.texel import Texel, draw_sample, splat
from core.overlay.tolerances import DRAWN, LEAST_NOISE, MOTIF_PX, NEARBY_PX

AROUND = 1.5
"""Width, in texels, of the neighbourhood in which something recurs."""
DOUBT = 3.0
"""Pixels at the same place below which it is half believed that something recurs there."""


def without_old_pattern(detail: Singles, uv: Singles, shading: Singles, texel: Texel, basis: Floats) -> Singles:
    """Return the detail (H, W, 3) of the cloth alone, to go with another texture.

    `uv` (H, W, 2), `shading` (H, W) or (H, W, 3) and `detail` are NaN outside the cloth; `basis` (2, 2) is pixels of
    undeformed cloth a texel. There is some cloth.
    """
    covered = finite(uv)
    rest, drawn = np.nan_to_num(detail), draw_sample(covered, DRAWN)
    noise = max(float(np.median(np.abs(rest[drawn]), overwrite_input=True)), LEAST_NOISE)
    find_recurring(rest, uv, drawn, texel.shape, noise).take_out(rest, uv, covered)
    rest = without_errors(rest, (uv, shading), texel, basis, noise)
    grain, out = grain_of(rest, uv, covered, texel.shape, basis), np.empty_like(rest)

    def keep_grain(first: int, top: int, bottom: int, last: int) -> None:
        part, own = slice(first, last), slice(top - first, bottom - first)
        out[top:bottom] = even_out(rest[part], uv[part], covered[part], grain)[own]

    in_bands(keep_grain, rest.shape, margin=int(3 * (NEARBY_PX + MOTIF_PX)))
    out[~covered] = np.nan
    return out


def without_errors(
    before: Singles, layers: tuple[Singles, Singles], texel: Texel, basis: Floats, noise: float
) -> Singles:
    """Return the detail (H, W, 3) without what small errors of the model leave in it.

    `before` is the detail without what recurs, `layers` are the coordinates and the shading.
    """
    (uv, shading), covered = layers, finite(layers[0])
    soft, rest = texel.blurred(1.0, basis), np.empty_like(before)

    def correct(first: int, top: int, bottom: int, last: int) -> None:
        part, own = slice(first, last), slice(top - first, bottom - first)
        effects = effects_of_errors(uv[part], shading[part], texel, soft, basis)
        rest[top:bottom] = (before[part] - explain(before[part], effects, covered[part], noise))[own]

    in_bands(correct, rest.shape, margin=int(6 * NEARBY_PX))
    return rest


@dataclass(frozen=True)
class Recurring:
    """What recurs at the same place of the texels around, over the texture."""

    means: Singles
    """(rows, columns, C)."""
    low: Singles
    """(2,), where the texture begins, texels."""
    density: Singles
    """(2,), samples a texel."""

    def at(self, uv: Singles) -> Singles:
        """Return it (n, C) at coordinates (n, 2)."""
        return look_up(self.means, (uv - self.low) * self.density - np.float32(0.5))

    def take_out(self, values: Singles, uv: Singles, covered: Bools) -> None:
        """Subtract it from values (H, W, C) at coordinates (H, W, 2) where cloth (H, W) is, in place."""

        def subtract(_first: int, top: int, bottom: int, _last: int) -> None:
            there = covered[top:bottom]
            values[top:bottom][there] -= self.at(uv[top:bottom][there])

        in_bands(subtract, values.shape)


def find_recurring(values: Singles, uv: Singles, drawn: Bools, shape: tuple[int, int], usual: float) -> Recurring:
    """Return what of values (H, W, C) on cloth at uv (H, W, 2), NaN elsewhere, recurs, from those that are `drawn`.

    `shape` (h, w) is that of the texel, `usual` how large a value usually is.
    """
    # By columns, which takes a fifth of the time.
    ends = uv.reshape(-1, 2).T
    low, high = (np.floor([end(axis) for axis in ends]).astype(np.float32) for end in (np.nanmin, np.nanmax))
    texels = (high - low).astype(np.int64)[::-1] + 1
    share = min(1.0, float(np.sqrt(DRAWN / (np.prod(texels) * np.prod(shape)))))
    h, w = (max(1, round(share * n)) for n in shape)
    rows, columns = int(texels[0]) * h, int(texels[1]) * w
    # A stain recurs nowhere: it must not be seen in its neighbours.
    at, seen = uv[drawn], np.clip(values[drawn], -4 * usual, 4 * usual)
    planes = np.zeros((values.shape[-1] + 1, rows * columns))
    for first in range(0, len(at), PIXELS):
        part = slice(first, first + PIXELS)
        index, shares = splat((at[part].astype(np.float64) - low) / texels[::-1], (rows, columns))
        for plane, value in zip(planes, (*seen[part].T[..., None], 1.0), strict=True):
            plane += np.bincount(index.ravel(), (shares * value).ravel(), rows * columns)
    by_texel = planes.T.astype(np.float32).reshape(int(texels[0]), h, int(texels[1]), -1)
    for axis in (0, 2):
        by_texel = scipy.ndimage.gaussian_filter1d(by_texel, AROUND, axis, mode="constant") * (
            AROUND * np.sqrt(2 * np.pi)
        )
    sums = by_texel.reshape(rows, columns, -1)
    # A pixel of the photo is several samples.
    mass = sums[..., -1:]
    means = sums[..., :-1] / (mass + DOUBT * len(at) / max(int((mass > 0.1).sum()), 1))
    return Recurring(means, low, np.array([w, h], np.float32))


def effects_of_errors(uv: Singles, shading: Singles, texel: Texel, soft: Texel, basis: Floats) -> list[Singles]:
    """Return what a shift right, a shift down and blur do to ρ T, (H, W, 3) each."""
    at, to_uv = np.nan_to_num(uv).astype(np.float64), np.linalg.inv(basis).astype(np.float32)
    light = np.nan_to_num(shading)
    light = light if light.ndim == 3 else light[..., None]
    value, du, dv = texel.singles_with_gradient(at)
    right, down = (du * to_uv[0, k] + dv * to_uv[1, k] for k in (0, 1))
    softer = soft(at).astype(np.float32) - value
    return [light * effect for effect in (right, down, softer)]


def explain(detail: Singles, effects: list[Singles], covered: Bools, noise: float) -> Singles:
    """Return the part (H, W, 3) of the detail that the effects explain best over the neighbourhood of each pixel."""
    inside = covered.astype(np.float32)[..., None]
    fine = detail - mean(detail, inside, NEARBY_PX)
    slopes = [effect - mean(effect, inside, NEARBY_PX) for effect in effects]
    weight = inside[..., 0] * np.minimum(1, 3 * noise / np.maximum(np.sqrt(dot(fine, fine) / 3), 1e-9))
    count = len(slopes)
    pairs = [(i, j) for i in range(count) for j in range(i, count)]
    products = [dot(slopes[i], slopes[j]) * weight for i, j in pairs]
    products += [dot(slope, fine) * weight for slope in slopes]
    means = [gaussian(product, NEARBY_PX) for product in products]
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
