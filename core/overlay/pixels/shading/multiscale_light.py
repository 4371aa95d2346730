"""The light on cloth, scale by scale: where the mesh is too coarse for it, and where the mesh cannot be trusted.

Over about a texel it is the photo's mean brightness over the texel's own, whatever lies where: with that the estimate
begins where the mesh's light is the pattern's. Nearer to a place it is the light in which the photo shows the model,
counted by how bright the model is: Σ I M / Σ M² over widths that grow, each counting less, so that dark motifs take
the light of what is beside them. Pixels that are no shade of the model do not count. Single pixels have a light of
their own as far as it is more than the photo's noise and what the pattern's edges would give if they lay a little
beside (Wiener's filter). What recurs at the same place of the texels around is the pattern's contrast and no light,
and is taken out.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.detail.residual_cleanup import find_recurring
from core.overlay.filters.bands import in_bands
from core.overlay.filters.smoothing import gaussian
from core.overlay.registration.region import LEAST_NOISE
from core.overlay.texel import Texel, draw_sample
from core.overlay.tolerances import DRAWN, MOTIF

WIDTHS, WEIGHTS = 2.0 ** np.arange(4), 0.15 ** np.arange(4)
"""Widths of the neighbourhoods, over the least, and how much each counts."""
LEAST_PX = 1.75
"""The least of them in pixels."""
USUAL = 0.02
"""How much the light counts as it is, over a pixel of the usual brightness."""
OFF = 0.35
"""How far such a pixel may be from the shade, over the model's brightness."""
RANGE = (0.4, 1.5)
"""Light in a fold, over that of the model; a pixel out of it shows another motif."""
CHANCE = 0.2
"""Change of the light, as its logarithm, up to four times of which something may recur."""
SAMPLES = 4
"""Means of squares to the least width: of more pixels than that a large photo's light is known. A single one's light is
that of so much, and the pattern's edges may lie so far beside where the model has them."""


def estimate_light(
    photo: Floats | Singles,
    texture: Singles,
    light: Singles,
    uv: Singles,
    texel: Texel,
    basis: Floats,
    *,
    scale: int = 1,
) -> Singles:
    """Return the light (H, W, 1) on the cloth over that of the model, 1 outside.

    `photo` and T(Wg), the `texture`, are (H, W, 3), the model's `light` (H, W, 1), `uv` (H, W, 2), NaN outside the
    cloth; `basis` (2, 2) is pixels of undeformed cloth a texel. In a photo of `scale` times the size the light is
    smooth over as many pixels, and is found from means over them where its widths allow that.
    """
    least = max(MOTIF * float(np.sqrt(abs(np.linalg.det(basis)))), LEAST_PX)
    every = int(np.clip(least / SAMPLES, 1, scale))
    covered = np.isfinite(uv[..., 0])
    seen, bright, usual = mean_shades(photo, texture, light, covered, every)
    if usual == 0:
        return np.ones((*covered.shape, 1), np.float32)
    smooth = log_light(*(sum_of_means(plane, usual, least / every) for plane in (seen, bright)))
    middles = np.ix_(*(np.minimum(np.arange(0, n, every) + every // 2, n - 1) for n in covered.shape))
    inside, places = (covered, uv) if every == 1 else (covered[middles], uv[middles])
    drawn = draw_sample(inside, DRAWN)

    def leave_out_recurring(change: Singles) -> None:
        """Take out of a change (h, w) of the light what recurs at the same place of the texels."""
        values = change[..., None]
        find_recurring(values, places, drawn, texel.shape, CHANCE).take_out(values, places, inside)

    width = least / every / SAMPLES
    fine, mass = (gaussian(plane, width) for plane in (seen, bright))
    del seen, bright
    more = log_light(fine, np.maximum(mass, 1e-6))
    more -= smooth
    more[mass <= 0] = 0
    leave_out_recurring(more)
    leave_out_recurring(smooth)
    smooth += keep_sure_part(more, mass, width)
    wide = smooth if every == 1 else cv2.resize(smooth, covered.shape[::-1], interpolation=cv2.INTER_LINEAR)
    np.exp(wide, out=wide)
    wide[~covered] = 1
    return np.asarray(wide[..., None], np.float32)


def log_light(seen: Singles, bright: Singles) -> Singles:
    """Return the logarithm of the light (H, W) by means of I M and M², in the place of the former."""
    np.divide(seen, bright, out=seen)
    np.clip(seen, *RANGE, out=seen)
    return np.asarray(np.log(seen, out=seen))


def keep_sure_part(more: Singles, bright: Singles, width_px: float) -> Singles:
    """Return what of a change (H, W) of the light is neither noise nor the pattern's edges, `width_px` beside.

    It is a logarithm; the model's square is `bright` (H, W), 0 where nothing counts.
    """
    usual, sure = bright.mean(where=bright > 0), np.empty_like(more)

    def keep(first: int, top: int, bottom: int, last: int) -> None:
        rows, own = slice(first, last), slice(top - first, bottom - first)
        counts = bright[rows] > 0
        level = np.log(np.where(counts, bright[rows], usual)) / 2
        slopes = np.gradient(level)
        noise = width_px**2 * (slopes[0] ** 2 + slopes[1] ** 2) + LEAST_NOISE / np.maximum(bright[rows], 1e-6)
        surplus, share = (
            gaussian(plane, SAMPLES * width_px)
            for plane in (counts * (more[rows] ** 2 - noise), counts.astype(np.float32))
        )
        power = np.maximum(surplus / np.maximum(share, 1e-3), 0)
        sure[top:bottom] = (counts * more[rows] * power / (power + noise))[own]

    in_bands(keep, more.shape, margin=int(3 * SAMPLES * width_px) + 1)
    return sure


def mean_shades(
    photo: Floats | Singles, texture: Singles, light: Singles, covered: Bools, every: int
) -> tuple[Singles, Singles, float]:
    """Return the means (h, w) of what `shades` does over squares of so many pixels, and what is usual, 0 for none.

    The model is texture times light.
    """
    both, own = np.empty((2, *covered.shape), np.float32)

    def compare(_first: int, top: int, bottom: int, _last: int) -> int:
        rows = slice(top, bottom)
        modelled = texture[rows] * np.nan_to_num(light[rows])
        both[rows], own[rows], counts = shades(photo[rows], modelled, covered[rows])
        return int(counts.sum())

    count = sum(in_bands(compare, photo.shape))
    return means_of(both, every), means_of(own, every), USUAL * float(own.sum(dtype=np.float64)) / max(count, 1)


def means_of(plane: Singles, every: int) -> Singles:
    """Return the means of a plane (H, W) over squares of so many pixels; the last ones may be smaller."""
    size = -(-plane.shape[1] // every), -(-plane.shape[0] // every)
    return plane if every == 1 else np.asarray(cv2.resize(plane, size, interpolation=cv2.INTER_AREA), np.float32)


def shades(photo: Floats | Singles, modelled: Singles, covered: Bools) -> tuple[Singles, Singles, Bools]:
    """Return I M and M² (H, W) where the photo is a shade of the model, 0 elsewhere; and where (H, W) it is."""
    pairs = ((photo, modelled), (modelled, modelled), (photo, photo))
    both, own, seen = (np.einsum("...c,...c", a, b, dtype=np.float32, casting="same_kind") for a, b in pairs)
    shade = both / np.maximum(own, 1e-6)
    counts = covered & (shade > RANGE[0]) & (shade < RANGE[1]) & (seen - shade * both < OFF**2 * own)
    return both * counts, own * counts, counts


def sum_of_means(plane: Singles, usual: float, least_px: float) -> Singles:
    """Return a plane's means (H, W) over the widths, each by what it counts, and what is `usual`."""
    total = np.full_like(plane, usual)
    for width, weight in zip(WIDTHS, WEIGHTS, strict=True):
        soft = gaussian(plane, width * least_px)
        soft *= np.float32(weight)
        total += soft
    return total
