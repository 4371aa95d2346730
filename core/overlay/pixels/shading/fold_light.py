"""The light in folds that are finer than the mesh.

Near a place the light is that in which the photo shows the model, counted by how bright the model is: Σ I M / Σ M² over
widths that grow, each counting less, so that dark motifs take the light of what is beside them. Pixels that are no
shade of the model do not count. What recurs at the same place of the texels around is the pattern's contrast and no
light, and is taken out.
"""

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.detail.residual_cleanup import recurring
from core.overlay.filters.bands import bands
from core.overlay.filters.smoothing import gaussian
from core.overlay.texel import Texel

WIDTHS, WEIGHTS = (1.0, 2.0, 4.0, 8.0), (1.0, 0.15, 0.0225, 0.003375)
"""Widths of the neighbourhoods, over the least, and how much each counts."""
LEAST, LEAST_PX = 0.05, 1.75
"""The least, over the side of a texel, and in pixels at least."""
USUAL = 0.02
"""How much the light counts as it is, over a pixel of the usual brightness."""
SHADES, LOST = (0.55, 1.6), (0.6, 1.5)
"""Light at a pixel, over that of the model, at which it is a shade of it, the second where that is not followed."""
OFF = 0.35
"""How far such a pixel may be from the shade, over the model's brightness."""
RANGE = (0.6, 1.5)
"""Light in a fold, over that of the model."""
CHANCE = 0.2
"""Change of the light, as its logarithm, up to four times of which something may recur."""


def fold_light(
    photo: Floats | Singles, modelled: Singles, uv: Singles, followed: Bools, texel: Texel, basis: Floats
) -> Singles:
    """Return the light (H, W, 1) on the cloth over that of the model (H, W, 3), 1 outside.

    `photo` is (H, W, 3), `uv` (H, W, 2), NaN outside the cloth, of which the `followed` (H, W) has been registered;
    `basis` (2, 2) is pixels of undeformed cloth a texel.
    """
    covered, out = np.isfinite(uv[..., 0]), np.ones((*followed.shape, 1), np.float32)
    both, own = np.empty((2, *followed.shape), np.float32)
    counts = np.empty(followed.shape, bool)
    for _, top, bottom, _ in bands(len(photo), margin=0):
        rows = slice(top, bottom)
        parts = shades(photo[rows], modelled[rows], covered[rows], followed[rows])
        both[rows], own[rows], counts[rows] = parts
    if not counts.any():
        return out
    usual = USUAL * float(own[counts].mean())
    least = max(LEAST * float(np.sqrt(abs(np.linalg.det(basis)))), LEAST_PX)
    both, own = (sum_of_means(plane, usual, least)[covered] for plane in (both, own))
    change = np.log(np.clip(both / own, *RANGE))[:, None]
    change -= recurring(change, uv[covered], texel.shape, CHANCE)
    out[covered] = np.exp(change, out=change)
    return out


def shades(
    photo: Floats | Singles, modelled: Singles, covered: Bools, followed: Bools
) -> tuple[Singles, Singles, Bools]:
    """Return I M and M² (H, W) where the photo is a shade of the model, 0 elsewhere; and where (H, W) it is."""
    pairs = ((photo, modelled), (modelled, modelled), (photo, photo))
    both, own, seen = (np.einsum("...c,...c", a, b, dtype=np.float32, casting="same_kind") for a, b in pairs)
    shade = both / np.maximum(own, 1e-6)
    low, high = (np.where(followed, *ends) for ends in zip(SHADES, LOST, strict=True))
    counts = covered & (shade > low) & (shade < high) & (seen - shade * both < OFF**2 * own)
    return both * counts, own * counts, counts


def sum_of_means(plane: Singles, usual: float, least_px: float) -> Singles:
    """Return a plane's means (H, W) over the widths, each by what it counts, and what is `usual`."""
    total = np.full_like(plane, usual)
    for width, weight in zip(WIDTHS, WEIGHTS, strict=True):
        total += np.float32(weight) * gaussian(plane, width * least_px)
    return total
