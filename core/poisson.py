"""Gradient-domain correction: a smooth field that takes given steps away.

With G the differences between neighbouring pixels (right and below) and J the steps to remove, the field c minimises

    |G c + J|^2 + e |c|^2        so that        (G'G + e) c = -G'J.

The second term screens: a correction fades within 1 / sqrt(e) px of its seam instead of tinting the whole picture. On a
rectangle with free edges the cosine transform makes the matrix diagonal: G'G has the eigenvalues
4 sin^2(pi k / 2W) + 4 sin^2(pi l / 2H).
"""

import numpy as np
import scipy

from core.arrays import Singles


def remove_steps(right: Singles, below: Singles, *, fade_px: float) -> Singles:
    """Return c (H, W, C) for steps `right` (H, W-1, C) and `below` (H-1, W, C)."""
    height, width, channels = below.shape[0] + 1, right.shape[1] + 1, right.shape[2]
    across = 4 * np.sin(np.pi * np.arange(width) / (2 * width)) ** 2
    down = 4 * np.sin(np.pi * np.arange(height) / (2 * height)) ** 2
    system = (across + down[:, None] + fade_px**-2).astype(np.float32)
    result = np.empty((height, width, channels), np.float32)
    for i in range(channels):
        sources = np.zeros((height, width), np.float32)
        sources[:, :-1] += right[..., i]
        sources[:, 1:] -= right[..., i]
        sources[:-1] += below[..., i]
        sources[1:] -= below[..., i]
        waves = scipy.fft.dctn(sources, norm="ortho", workers=2) / system
        result[..., i] = scipy.fft.idctn(waves, norm="ortho", workers=2)
    return result
