"""Gaussian means, and a picture freed of slow changes of light."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from core.arrays import Bools, Singles

LIGHT_PX = 25.0
"""Changes of light slower than this are taken out before patches are compared."""


def gaussian(values: NDArray[Any], sigma_px: float) -> NDArray[Any]:
    """Return the Gaussian mean of planes (H, W) or (H, W, C), mirrored at the border.

    A wide one is taken of means over squares, which differs by less than 1 % of the values.
    """
    step = min(int(sigma_px / 4), min(values.shape[:2]) // 8)
    if step < 2:
        return np.asarray(cv2.GaussianBlur(values, (0, 0), sigma_px, borderType=cv2.BORDER_REFLECT))
    h, w = values.shape[:2]
    rest = [(0, -n % step) for n in (h, w)] + [(0, 0)] * (values.ndim - 2)
    padded = np.pad(values, rest, mode="symmetric") if np.any(rest) else values
    size = padded.shape[1] // step, padded.shape[0] // step
    small = cv2.resize(padded, size, interpolation=cv2.INTER_AREA)
    soft = cv2.GaussianBlur(small, (0, 0), sigma_px / step, borderType=cv2.BORDER_REFLECT)
    return np.asarray(cv2.resize(soft, padded.shape[1::-1], interpolation=cv2.INTER_LINEAR)[:h, :w])


def mean(values: Singles, weight: Singles, sigma_px: float) -> Singles:
    """Return the mean of values (H, W, C) over neighbourhoods, under weights (H, W, 1 or C)."""
    total = gaussian(values * weight, sigma_px)
    mass = gaussian(weight, sigma_px).reshape(*weight.shape)
    return np.asarray(total / np.maximum(mass, 1e-4), np.float32)


def flatten(image: Singles, valid: Bools, sigma_px: float) -> Singles:
    """Divide `image` (H, W, 3) by its local brightness (a Gaussian mean over `valid`); zero outside."""
    inside = valid.astype(np.float32)
    brightness = image.mean(-1) * inside
    mean = gaussian(brightness, sigma_px) / np.maximum(gaussian(inside, sigma_px), 1e-3)
    floor = max(0.02, 0.1 * float(mean[valid].mean())) if valid.any() else 1.0
    return np.asarray(image / np.maximum(mean, floor)[..., None] * inside[..., None], np.float32)


def shrink_ground(image: Singles, valid: Bools, sigma_px: float) -> Singles:
    """Return a flattened image (H, W, 3) in which what differs little from the mean colour around it differs less.

    Of sparse motifs most pixels are ground, whose folds and weave outweigh the motifs wherever patches are compared.
    A difference d is shrunk to d |d| / √(|d|² + s²), where s is the ground's standard deviation, told by the median
    in `valid`: less than that counts with its square, more as it is. Where all pixels differ as much, as of checks, all
    but their edges are shrunk alike. The mean is over a Gaussian neighbourhood of `sigma_px`; |d| is freed of grain.
    Zero outside.
    """
    if not valid.any():
        return image
    inside = valid.astype(np.float32)[..., None]
    ground = mean(image, inside, sigma_px)
    rest = (image - ground) * inside
    squared = (gaussian(rest, 1.0) ** 2).sum(-1)
    variance = 1.4826**2 * float(np.median(squared[valid]))
    kept = np.sqrt(squared / (squared + variance + 1e-9))
    return np.asarray(ground * inside + rest * kept[..., None], np.float32)
