"""How far pixels lie from a mask."""

import cv2
import numpy as np

from core.arrays import Bools, Singles


def distance(mask: Bools) -> Singles:
    """Return how far (H, W) pixels are from a mask."""
    return np.asarray(cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5), np.float32)


def within(mask: Bools, most_px: float) -> Bools:
    """Return the pixels (H, W) at most so far from a mask."""
    return np.asarray(distance(mask) <= most_px, np.bool_) if mask.any() else np.zeros(mask.shape, bool)
