"""The few colours of a pattern, and how far a photo is from shades of them."""

import numpy as np

from core.arrays import Floats, Singles
from core.overlay.filters.k_means import find_groups
from core.overlay.texel import Texel

MANY, COLOURS, GROUPS = 8, 5, 3
"""Colours that stand for all of a texel's, for those that have patches, and of which the patches are told apart."""
SAMPLES = 40_000
"""Samples of a texel that tell its colours at least: four times as many are thinned out."""


def palette(texel: Texel, most: int = COLOURS) -> Singles:
    """Return the means (k, 3) of the groups, `most` at most, that the texel's colours fall into."""
    if most not in texel.palettes:
        texel.palettes[most] = find_palette(texel, most)
    return texel.palettes[most]


def find_palette(texel: Texel, most: int) -> Singles:
    """Return what `palette` does, from as many of a large texel's samples as tell it."""
    every = max(1, int(np.sqrt(texel.shape[0] * texel.shape[1] / SAMPLES)))
    pixels = texel.pixels[::every, ::every].reshape(-1, 3)
    return find_groups(pixels, most)[1]


def from_shades(photo: Floats | Singles, colour: Floats | Singles, shades: tuple[float, float]) -> Floats | Singles:
    """Return how far (...) a photo is from any shade of colours (..., 3), of the darkest to the brightest one."""
    # Channel by channel: operations on three numbers at a time take several times as long.
    planes = [(photo[..., c], colour[..., c]) for c in range(photo.shape[-1])]
    both, own = sum(seen * wanted for seen, wanted in planes), sum(wanted**2 for _, wanted in planes)
    shade = np.clip(both / np.maximum(own, 1e-9), *shades)
    off: Floats | Singles = np.sqrt(sum((seen - shade * wanted) ** 2 for seen, wanted in planes))
    return off
