"""Reading arrays between their pixels."""

from enum import IntEnum

import cv2
import numpy as np

from core.arrays import Bytes, Pixels, Points, Singles

LONGEST = 32_000
"""OpenCV reads no more places in a row or column."""


class Kernel(IntEnum):
    """How values between pixels come about."""

    NEAREST = cv2.INTER_NEAREST
    LINEAR = cv2.INTER_LINEAR
    CUBIC = cv2.INTER_CUBIC
    LANCZOS = cv2.INTER_LANCZOS4
    """Eight by eight pixels: next to nothing of what a picture can hold is lost."""


def read(picture: Singles, at: Singles | Points, kernel: Kernel = Kernel.LINEAR, *, mirror: bool = False) -> Singles:
    """Return a picture (H, W) or (H, W, C), C at most 4, at places (..., 2): (...) or (..., C).

    Outside, its border goes on, or with `mirror` its mirror image.
    """
    return np.asarray(
        _remapped(picture, at, kernel, cv2.BORDER_REFLECT_101 if mirror else cv2.BORDER_REPLICATE), np.float32
    )


def read_nearest(levels: Bytes, at: Singles) -> Bytes:
    """Return the pixels of `levels` (H, W) nearest to places (..., 2): (...); 0 outside."""
    return np.asarray(_remapped(levels, at, Kernel.NEAREST, cv2.BORDER_CONSTANT), np.uint8)


def read_stored(pixels: Pixels, at: Singles) -> Pixels:
    """Return pixels (H, W, C) at places (..., 2), of their own depth, for a quick look: by a kernel of 4 x 4 pixels."""
    return _remapped(pixels, at, Kernel.CUBIC, cv2.BORDER_REFLECT_101)


def _remapped(picture: Pixels, at: Singles | Points, kernel: Kernel, border: int) -> Pixels:
    places = np.ascontiguousarray(at, np.float32)
    if places.ndim != 3 or max(places.shape[:2]) > LONGEST:
        places = places.reshape(1, -1, 2)
    parts = []
    for i in range(0, places.shape[1] if places.size else 0, LONGEST):
        some = np.ascontiguousarray(places[:, i : i + LONGEST])
        # The stubs know neither None for the second map nor that it must be None beside a map of pairs.
        parts.append(cv2.remap(picture, some, None, kernel.value, borderMode=border))  # type: ignore[call-overload]
    if not parts:
        return np.empty((*at.shape[:-1], *picture.shape[2:]), picture.dtype)
    whole = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
    return whole.reshape(*at.shape[:-1], *picture.shape[2:])
