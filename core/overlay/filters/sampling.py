"""An image at a list of places."""

import cv2
import numpy as np

from core.arrays import Points, Singles

WIDTH = 4096
"""A list is looked up in rows of this length: remap takes at most 32767 rows or columns."""


def look_up(image: Singles, at: Points | Singles) -> Singles:
    """Return an image (H, W, C) at places (n, 2), columns first, bilinear, its border carried on: (n, C)."""
    padded = np.zeros((-(-len(at) // WIDTH) * WIDTH, 2), np.float32)
    padded[: len(at)] = at
    x, y = np.ascontiguousarray(padded.T).reshape(2, -1, WIDTH)
    if not len(at):
        return np.zeros((0, image.shape[-1]), np.float32)
    found = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(found, np.float32).reshape(-1, image.shape[-1])[: len(at)]
