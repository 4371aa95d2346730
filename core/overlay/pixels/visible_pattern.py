"""What is taken for a thing on the cloth, and yet shows the pattern: it is cloth in light of another colour.

Over a thing of one colour the photo is no better told by the texture, in whatever light, than by its own mean nearby.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats
from core.overlay.filters.smoothing import gaussian

SHOWN = 0.35
"""Share of the photo's variance that the texture explains over what is cloth."""
LEAST = 1e-6


def without_cloth(things: Bools, photo: Floats, texture: Floats, covered: Bools, sigma_px: float) -> Bools:
    """Return those connected parts of `things` (H, W) over which the texture does not explain the photo.

    `photo` and `texture`, which is T(uv), are (H, W, 3). The light of each channel, and the mean that it is compared
    with, are those of the `covered` neighbourhood within `sigma_px`, the thing's own pixels alone.
    """
    count, labels = cv2.connectedComponents(things.astype(np.uint8), connectivity=4)
    if count == 1:
        return things
    inside = (things & covered).astype(np.float64)[..., None]
    mass = np.maximum(gaussian(inside[..., 0], sigma_px), LEAST)[..., None]
    both, own = (gaussian(inside * texture * other, sigma_px) for other in (photo, texture))
    lit = both / np.maximum(own, LEAST) * texture
    even = gaussian(inside * photo, sigma_px) / mass
    errors = [
        np.bincount(labels.ravel(), (inside * (photo - model) ** 2).sum(-1).ravel(), count) for model in (lit, even)
    ]
    shows = 1 - errors[0] / np.maximum(errors[1], LEAST) > SHOWN
    return np.asarray(things & ~shows[labels], np.bool_)
