"""The few colours of a pattern, and how far a photo is from shades of them."""

import cv2
import numpy as np

from core.arrays import Floats, Singles
from core.overlay.texel import Texel

COLOURS, GROUPS = 5, 3
"""Colours that stand for those of a texel, and of which the patches are told apart."""
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
    count = min(most, len(pixels))
    main = np.linalg.svd(pixels - pixels.mean(0), full_matrices=False)[2][0]
    # Groups of one size along the direction of most change, to begin with: always the same ones.
    labels = np.empty((len(pixels), 1), np.int32)
    labels[np.argsort(pixels @ main, kind="stable"), 0] = np.arange(len(pixels)) * count // len(pixels)
    rule = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 30, 1e-4)
    found = cv2.kmeans(pixels.astype(np.float32), count, labels, rule, 1, cv2.KMEANS_USE_INITIAL_LABELS)[2]
    return np.asarray(found, np.float32)


def from_shades(photo: Floats, colour: Floats, shades: tuple[float, float]) -> Floats:
    """Return how far (...) a photo is from any shade of colours (..., 3), of the darkest to the brightest one."""
    # Channel by channel: operations on three numbers at a time take several times as long.
    planes = [(photo[..., c], colour[..., c]) for c in range(photo.shape[-1])]
    both, own = sum(seen * wanted for seen, wanted in planes), sum(wanted**2 for _, wanted in planes)
    shade = np.clip(both / np.maximum(own, 1e-9), *shades)
    return np.asarray(np.sqrt(sum((seen - shade * wanted) ** 2 for seen, wanted in planes)), np.float64)
