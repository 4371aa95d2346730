"""Seams a pixel wide: beside a seam a pixel shows a little of the neighbouring patch, as an antialiased edge would.

The neighbouring patch is carried on by its own last step: with p beyond a seam from q, and r behind q, it would show
at p the place 2 place(q) - place(r). Both places are resampled and mixed, so that no detail is filtered twice.
"""

from dataclasses import dataclass

import numpy as np

from core.arrays import Ints, Singles

SHARE = 0.25
"""How much a pixel shows of the patch across each of its seams."""


@dataclass(frozen=True, eq=False)
class Mixture:
    """Pixels (n,) of the flattened picture, in order, and the places (n, 2) they show besides their own."""

    pixel: Ints
    place: Singles

    def rows(self, start: int, stop: int, width: int) -> "Mixture":
        """Return the part in some rows; its pixels count from the first of them."""
        low, high = np.searchsorted(self.pixel, [start * width, stop * width])
        return Mixture(self.pixel[low:high] - start * width, self.place[low:high])


def across_seams(place: Singles, label: Ints) -> Mixture:
    """Return what pixels of patches show of their neighbours' (H, W, 2) places; label 0 stays as it is."""
    height, width = label.shape
    pixels, places = [], []
    for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        y0, x0 = max(-2 * down, 0), max(-2 * right, 0)
        y1, x1 = height - max(2 * down, 0), width - max(2 * right, 0)
        here, beyond, behind = (
            (slice(y0 + i * down, y1 + i * down), slice(x0 + i * right, x1 + i * right)) for i in range(3)
        )
        seam = (label[here] > 0) & (label[here] != label[beyond]) & (label[beyond] == label[behind])
        y, x = np.nonzero(seam)
        pixels.append((y + y0) * width + x + x0)
        places.append(2 * place[beyond][y, x] - place[behind][y, x])
    pixel = np.concatenate(pixels)
    order = np.argsort(pixel, kind="stable")
    return Mixture(pixel[order], np.concatenate(places)[order])
