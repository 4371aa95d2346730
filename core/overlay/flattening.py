"""A picture freed of slow changes of light, for comparing patches."""

import cv2
import numpy as np

from core.arrays import Bools, Singles


def flatten(image: Singles, valid: Bools, sigma_px: float) -> Singles:
    """Divide `image` (H, W, 3) by its local brightness (a Gaussian mean over `valid`); zero outside."""
    inside = valid.astype(np.float32)
    brightness = image.mean(-1) * inside
    mean = blur(brightness, sigma_px) / np.maximum(blur(inside, sigma_px), 1e-3)
    floor = max(0.02, 0.1 * float(mean[valid].mean())) if valid.any() else 1.0
    return np.asarray(image / np.maximum(mean, floor)[..., None] * inside[..., None], np.float32)


def blur(values: Singles, sigma_px: float) -> Singles:
    """Return the Gaussian mean of `values`, mirrored at the border."""
    return np.asarray(cv2.GaussianBlur(values, (0, 0), sigma_px, borderType=cv2.BORDER_REFLECT), np.float32)
