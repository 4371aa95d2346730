"""How far pixels lie from a mask."""

import cv2
import numpy as np

from core.arrays import Bools, Ints, Singles


def distance(mask: Bools) -> Singles:
    """Return how far (H, W) pixels are from a mask."""
    return np.asarray(cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5), np.float32)


def within(mask: Bools, most_px: float) -> Bools:
    """Return the pixels (H, W) at most so far from a mask."""
    return np.asarray(distance(mask) <= most_px, np.bool_) if mask.any() else np.zeros(mask.shape, bool)


def open_by_disc(mask: Bools, radius_px: float) -> Bools:
    """Return what discs of that radius cover of a mask (H, W); beyond the picture's edge all is in the mask."""
    return within(distance(~mask) > radius_px, radius_px) if not mask.all() else mask


def nearest_of(mask: Bools) -> tuple[Singles, Ints]:
    """Return how far (H, W) pixels are from a mask, and the number (H, W) of the nearest pixel of it."""
    away, labels = cv2.distanceTransformWithLabels(
        (~mask).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    number = np.zeros(int(labels.max()) + 1, np.int64)
    number[labels[mask]] = np.flatnonzero(mask)
    return np.asarray(away, np.float32), number[labels]
