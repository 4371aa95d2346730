"""Gradient-domain correction: a smooth field that takes given steps away.

With G the differences between neighbouring pixels (right and below) and J the steps to remove, the field c minimises

    |G c + J|^2 + e |c|^2        so that        (G'G + e) c = -G'J.

The second term screens: a correction fades within 1 / sqrt(e) px of its seam instead of tinting the whole picture. On a
rectangle with free edges the cosine transform makes the matrix diagonal: G'G has the eigenvalues
4 sin^2(pi k / 2W) + 4 sin^2(pi l / 2H).
"""

import cv2
import numpy as np

from core.arrays import Singles


def remove_steps(right: Singles, below: Singles, *, fade_px: float) -> Singles:
    """Return c (H, W, C) for steps `right` (H, W-1, C) and `below` (H-1, W, C)."""
    height, width, channels = below.shape[0] + 1, right.shape[1] + 1, right.shape[2]
    # The free edges lie a little farther out, where the transform is faster.
    tall, wide = (2 * cv2.getOptimalDFTSize((side + 1) // 2) for side in (height, width))
    across = 4 * np.sin(np.pi * np.arange(wide) / (2 * wide)) ** 2
    down = 4 * np.sin(np.pi * np.arange(tall) / (2 * tall)) ** 2
    system = (across + down[:, None] + fade_px**-2).astype(np.float32)
    result = np.empty((height, width, channels), np.float32)
    for i in range(channels):
        sources = np.zeros((tall, wide), np.float32)
        sources[:height, : width - 1] += right[..., i]
        sources[:height, 1:width] -= right[..., i]
        sources[: height - 1, :width] += below[..., i]
        sources[1:height, :width] -= below[..., i]
        result[..., i] = cv2.idct(cv2.dct(sources) / system)[:height, :width]
    return result
