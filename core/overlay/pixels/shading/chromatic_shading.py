"""Coloured light: where it changes over the cloth, each channel has a shading of its own."""

import numpy as np

from core.arrays import Bools, Floats
from core.overlay.filters.smoothing import gaussian

FAINT = 0.04
"""Energy of a channel, over the strongest one's, at which it is half believed."""
NOTICED = 0.065
"""Change of a channel against the others, at the strongest tenth of the cloth, from which light counts as coloured."""


def find_tint(photo: Floats, modelled: Floats, inside: Bools, sigma_px: float) -> Floats | None:
    """Return each channel's own factor (H, W, 3), of mean one over the channels, or None where light has one colour.

    With I the photo and M the model, the factor of a channel over a neighbourhood is the one that fits best:
    g = Σ I M / Σ M². Coloured light changes cov(I, M) / var M in the same way, haze and gloss do not.
    """
    if not inside.any():
        return None
    w = inside[..., None].astype(np.float32)
    fields = (photo, modelled, photo * modelled, modelled**2)
    seen, model, both, own = (gaussian((a * w).astype(np.float32), sigma_px).astype(np.float64) for a in fields)
    mass = np.maximum(gaussian(w[..., 0], sigma_px).astype(np.float64), 1e-6)[..., None]
    through, beside = changes(both, own, inside), changes(both - seen * model / mass, own - model**2 / mass, inside)
    common = np.where(through * beside > 0, np.minimum(np.abs(through), np.abs(beside)), 0.0)
    coloured = np.percentile(common[inside].max(-1), 90) > NOTICED
    return np.clip(1 + through, 0.4, 2.5) if coloured else None


def changes(both: Floats, own: Floats, inside: Bools) -> Floats:
    """Return how much each channel's factor `both` / `own` (H, W, 3) is off the usual one, against the others."""
    # A channel that the cloth hardly has says more about haze than about the light.
    floor = FAINT * own.max(-1, keepdims=True) + 1e-9
    gain = (both + floor) / (own + floor)
    gain = gain / np.maximum(gain.mean(-1, keepdims=True), 1e-6)
    # A change that is the same everywhere is the texel's colour, not the light's.
    gain = gain / np.maximum(np.median(gain[inside], axis=0), 1e-6)
    return np.asarray(gain / np.maximum(gain.mean(-1, keepdims=True), 1e-6) - 1, np.float64)
