"""Coloured light: where it changes over the cloth, each channel has a shading of its own."""

import numpy as np

from core.arrays import Bools, Floats
from core.overlay.smoothing import gaussian

FAINT = 0.04
"""Energy of a channel, over the strongest one's, at which it is half believed."""
NOTICED = 0.05
"""Change of a channel against the others, at the strongest tenth of the cloth, from which light counts as coloured."""


def tint(photo: Floats, modelled: Floats, inside: Bools, sigma_px: float) -> Floats | None:
    """Return each channel's own factor (H, W, 3), of mean one over the channels, or None where light has one colour.

    With I the photo and M the model, the factor of a channel over a neighbourhood is the one that fits best:
    g = Σ I M / Σ M².
    """
    w = inside[..., None].astype(np.float32)
    both, own = (
        gaussian((a * modelled * w).astype(np.float32), sigma_px).astype(np.float64) for a in (photo, modelled)
    )
    # A channel that the cloth hardly has says more about haze than about the light.
    floor = FAINT * own.max(-1, keepdims=True) + 1e-9
    gain = (both + floor) / (own + floor)
    gain = gain / gain.mean(-1, keepdims=True)
    # A change that is the same everywhere is the texel's colour, not the light's.
    gain = gain / np.median(gain[inside], axis=0) if inside.any() else gain
    gain = gain / gain.mean(-1, keepdims=True)
    changes = np.abs(gain[inside] - 1).max(-1) if inside.any() else np.zeros(1)
    return np.clip(gain, 0.4, 2.5) if np.percentile(changes, 90) > NOTICED else None
