"""The cloth's border as a matte: what share of a pixel there is cloth, and the layers as far as any of it is.

A pixel of the border shows I = α F + (1 - α) B, with F = ρ T(uv) the model, carried on past the border, and B the mean
of the surroundings nearby. With a noise of variance σ² in each of three channels, and α known beforehand to be about
a0 ± `DOUBT` from the outline alone, the likeliest share is

    α = ((I - B) · (F - B) / σ² + a0 / DOUBT²) / (|F - B|² / σ² + 1 / DOUBT²).

F may also be any other colour of the pattern in that light, for the model may lie beside it: α is the mean over them
all, each by how likely it is. A new texture F' in place of F gives I + α (F' - F): neither a rim of the old one nor a
halo is left.
"""

from collections.abc import Callable

import cv2
import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filters.bands import bands
from core.overlay.filters.distances import distance
from core.overlay.texel import draw_sample
from core.overlay.tolerances import LEAST_NOISE, NEARBY_PX, RIM_PX, TYPICAL

DOUBT = 0.25
"""How far the share of cloth in a pixel is from what the outline alone tells."""
LEAST_SEEN = 0.01
"""Least share of the neighbourhood that is surroundings."""


def matte_of(
    photo: Floats | Singles,
    modelled_at: Callable[[Bools], Singles],
    light_at: Callable[[Bools], Singles],
    colours: Singles,
    inside: Bools,
    carried: Bools,
) -> Singles:
    """Return the share of cloth (H, W) in each pixel: 1 inside, 0 outside what is `carried`, soft in a band between.

    `photo` is (H, W, 3); `modelled_at` and `light_at` return the model (n, 3) and its light (n, 1 or 3) at marked
    pixels (H, W) as far as it is `carried` (H, W); `colours` (k, 3) are the pattern's, `inside` (H, W) the outline.
    """
    depth = distance(~inside)
    depth -= distance(inside)
    share = inside.astype(np.float32)
    near, grounds = np.zeros(inside.shape, bool), []
    for first, top, bottom, last in bands(photo.shape, margin=int(4 * NEARBY_PX) + 1):
        part, own = slice(first, last), slice(top - first, bottom - first)
        if np.abs(depth[top:bottom]).min() > RIM_PX:
            continue
        around = np.asarray(depth[part] < -RIM_PX, np.float32)
        mass = cv2.GaussianBlur(around, (0, 0), NEARBY_PX)[own]
        here = carried[top:bottom] & (np.abs(depth[top:bottom]) <= RIM_PX) & (mass > LEAST_SEEN)
        ground = cv2.GaussianBlur(photo[part].astype(np.float32) * around[..., None], (0, 0), NEARBY_PX)[own]
        grounds.append(ground[here] / mass[here][:, None])
        near[top:bottom] = here
    if not grounds:
        return share
    ground, core = np.concatenate(grounds), draw_sample(inside & ~near, TYPICAL)
    errors = np.abs(photo[core] - modelled_at(core)) if core.any() else np.zeros(1)
    variance = max(1.4826 * float(np.median(errors, overwrite_input=True)), LEAST_NOISE) ** 2
    # The outline runs half a pixel from the first pixels to its sides.
    known = np.clip(0.5 + (depth[near] - 0.5 * np.sign(depth[near])) / RIM_PX, 0, 1)
    cloth = [modelled_at(near) - ground, *(light_at(near) * colour - ground for colour in colours)]
    told = [tell(photo[near] - ground, one, known, variance) for one in cloth]
    costs, found, spread = (np.stack(part) for part in zip(*told, strict=True))
    costs[1:] += np.log(len(colours))
    odds = np.exp(costs.min(0) - costs)
    odds /= odds.sum(0)
    mean = (odds * found).sum(0)
    variance_of_mean = (odds * (spread + (found - mean) ** 2)).sum(0)
    # What is less than its own error is none.
    share[near] = np.where(mean > np.sqrt(variance_of_mean), mean, 0)
    return share


def tell(
    seen: Floats | Singles, cloth: Singles, known: Floats, variance: float
) -> tuple[Floats | Singles, Floats | Singles, Floats | Singles]:
    """Return how unlikely (n,), as a logarithm, pixels are a share of one colour, that share, and its variance.

    What is `seen` (n, 3), and the colour of the `cloth` (n, 3), are beyond the surroundings; `known` (n,) is the share
    that the outline tells.
    """
    certain = (cloth**2).sum(-1) / variance + 1 / DOUBT**2
    share = np.clip(((seen * cloth).sum(-1) / variance + known / DOUBT**2) / certain, 0, 1)
    missed = ((seen - share[:, None] * cloth) ** 2).sum(-1) / variance + ((share - known) / DOUBT) ** 2
    return (missed + np.log(certain)) / 2, share, 1 / certain
