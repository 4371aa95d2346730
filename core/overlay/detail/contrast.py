"""The pattern in another contrast than the model's: gloss and haze fade it, each channel in its own way.

Over about a texel the detail follows the model's own difference from its mean: HF = a (M - mean M) + rest. The amount a
is found by regression, in which pixels count less whose detail is no matter of contrast.
"""

from dataclasses import dataclass

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.composition import finite
from core.overlay.filters.sampling import look_up
from core.overlay.filters.smoothing import gaussian
from core.overlay.texel import Texel

AROUND = 0.5
"""Width of the neighbourhood, over the side of a texel."""
SAMPLES = 6
"""Samples to that width."""
USUAL = 4.0
"""Detail, over the usual one, that counts half."""

SLIGHT = 0.03
"""Amount that is half believed: an edge that is a little less sharp looks like it."""


@dataclass(frozen=True)
class Contrast:
    """How the contrast changes, at every so many pixels."""

    amount: Singles
    """(h, w, 3), a."""
    mean: Singles
    """(h, w, 3), the mean of the model."""
    step: int
    """Pixels from one sample to the next."""

    def within(self, model: Singles, covered: Bools, top: int) -> Singles:
        """Return a (M - mean M) (H, W, 3) for a model of the rows from `top` on, 0 where it is not `covered`."""
        cloth = np.flatnonzero(covered)
        rows, columns = np.divmod(cloth, covered.shape[1])
        at = (np.stack([columns, rows + top], -1) / self.step).astype(np.float32)
        out = np.zeros((covered.size, 3), np.float32)
        out[cloth] = look_up(self.amount, at) * (model.reshape(-1, 3).take(cloth, 0) - look_up(self.mean, at))
        return out.reshape(model.shape)


def contrast_of(detail: Singles, uv: Singles, shading: Singles, texel: Texel, basis: Floats, noise: float) -> Contrast:
    """Return the contrast that the detail (H, W, 3) has of the pattern; what is not cloth is NaN in `uv` (H, W, 2).

    `shading` is (H, W) or (H, W, 3), `basis` (2, 2) pixels of undeformed cloth a texel, `noise` the usual detail.
    """
    width = AROUND * float(np.sqrt(abs(np.linalg.det(basis))))
    step = max(1, int(width / SAMPLES))
    few = slice(None, None, step), slice(None, None, step)
    covered, light = finite(uv[few]), np.nan_to_num(shading[few])
    at = np.nan_to_num(uv[few]).astype(np.float64)
    model = (light if light.ndim == 3 else light[..., None]) * texel(at).astype(np.float32)
    seen = detail[few]
    size = np.einsum("...c,...c", seen, seen) / 3
    weight = (covered / (1 + size / (USUAL * noise) ** 2)).astype(np.float32)[..., None]
    planes = np.concatenate([np.ones_like(model), model, seen, model**2, model * seen], -1) * weight
    sums = gaussian(planes, width / step)
    own, other, squares, products = np.split(sums[..., 3:] / np.maximum(sums[..., :1], 1e-6), 4, axis=-1)
    amount = (products - own * other) / (squares - own**2 + noise**2)
    amount = np.clip(amount, -1, 1) * amount**2 / (amount**2 + SLIGHT**2)
    return Contrast(np.asarray(amount, np.float32), np.asarray(own, np.float32), step)
