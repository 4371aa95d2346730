"""An image at a list of places."""

import cv2
import numpy as np

from core.arrays import Points, Singles

WIDTH = 4096
"""A list is looked up in rows of this length."""
MOST_ROWS = int(np.iinfo(np.int16).max) - 1
"""That OpenCV takes at a time."""
ROWS = 64
"""So many of them are looked up at a time."""


def look_up(image: Singles, at: Points | Singles) -> Singles:
    """Return an image (H, W, C) at places (n, 2), columns first, bilinear, its border carried on: (n, C)."""
    out = np.empty((len(at), image.shape[-1]), np.float32)
    for first in range(0, len(at), ROWS * WIDTH):
        part = at[first : first + ROWS * WIDTH]
        places = np.zeros((2, -(-len(part) // WIDTH) * WIDTH), np.float32)
        places[:, : len(part)] = part.T
        x, y = places.reshape(2, -1, WIDTH)
        found = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        out[first : first + len(part)] = found.reshape(-1, image.shape[-1])[: len(part)]
    return out


def remap(image: Singles, x: Singles, y: Singles) -> Singles:
    """Return an image (H, W, C) at columns x (K, M) and rows y (K, M), bilinear, zero outside: (K, M, C)."""
    parts = [np.s_[first : first + MOST_ROWS] for first in range(0, len(x), MOST_ROWS)]
    found = [cv2.remap(image, x[part], y[part], cv2.INTER_LINEAR) for part in parts] or [np.empty(0, np.float32)]
    out = found[0] if len(found) == 1 else np.concatenate(found)
    return np.asarray(out, np.float32).reshape(*x.shape, image.shape[2])


def spread(plane: Singles, shape: tuple[int, ...], every: int) -> Singles:
    """Return a plane (h, w) or (h, w, C) of every so many pixels at all of a `shape` (H, W)."""
    at = np.diag([1 / every, 1 / every, 1.0])[:2]
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    wide = cv2.warpAffine(plane, at, shape[1::-1], flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(wide, np.float32)
