"""Selections by colour. A picture is (H, W, 3) of encoded 8-bit colours, as `core.imaging.proxy` makes it."""

import cv2
import numpy as np

from core.arrays import Bytes

SOFTNESS = 0.5
"""Beyond the tolerance a range of colours fades out over this share of it."""


def select_alike(picture: Bytes, at: tuple[int, int], tolerance: int, *, contiguous: bool) -> Bytes:
    """Return the mask (H, W) of the pixels whose channels differ by at most `tolerance` from those at `at` (x, y).

    With `contiguous`, only those that hang together with it by their sides.
    """
    if not contiguous:
        apart = np.abs(picture.astype(np.int16) - picture[at[1], at[0]].astype(np.int16)).max(axis=2)
        return np.where(apart <= tolerance, 255, 0).astype(np.uint8)
    mask = np.zeros((picture.shape[0] + 2, picture.shape[1] + 2), np.uint8)
    flags = 4 | 255 << 8 | cv2.FLOODFILL_MASK_ONLY | cv2.FLOODFILL_FIXED_RANGE
    # With MASK_ONLY the picture is read only, but OpenCV asks for one that may be written.
    cv2.floodFill(picture.copy(), mask, at, (0,), (tolerance,) * 3, (tolerance,) * 3, flags)
    return np.ascontiguousarray(mask[1:-1, 1:-1])


def select_range(picture: Bytes, samples: Bytes, tolerance: float) -> Bytes:
    """Return the mask (H, W) of colours near one of `samples` (n, 3), as the eye sees them: by distance in CIELAB.

    Whole up to `tolerance`, fading out beyond it.
    """
    lab = _lab(picture)
    nearest = np.full(picture.shape[:2], np.inf, np.float32)
    for sample in _lab(samples[None])[0]:
        np.minimum(nearest, np.sqrt(((lab - sample) ** 2).sum(axis=2)), out=nearest)
    fading = max(SOFTNESS * tolerance, 1e-6)
    return np.asarray(np.rint(255 * np.clip(1 - (nearest - tolerance) / fading, 0, 1)), np.uint8)


def _lab(colours: Bytes) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    """Return CIELAB colours of (h, w, 3) encoded ones."""
    return np.asarray(cv2.cvtColor(np.ascontiguousarray(colours, np.float32) / 255, cv2.COLOR_RGB2LAB), np.float32)
