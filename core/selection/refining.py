"""Masks made larger, smaller, smoother or softer, and without holes.

All begin from the area A over 127 of a mask (H, W) and the distance d of each pixel's centre from A's edge, in pixels,
positive inside.
"""

import cv2
import numpy as np
import scipy

from core.arrays import Bytes, Singles

MARKED = 127
"""Over this a pixel is in the area."""


def distance_inside(mask: Bytes) -> Singles:
    """Return d (H, W): how far inside the area each pixel lies, negative outside; infinite where there is no edge."""
    inside = (mask > MARKED).astype(np.uint8)
    if inside.all() or not inside.any():
        return np.full(mask.shape, np.inf if inside.all() else -np.inf, np.float32)
    depth, away = (cv2.distanceTransform(side, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) for side in (inside, 1 - inside))
    # From centre to centre of the nearest pixel on the other side: the edge lies half a pixel before it.
    return np.asarray(np.where(inside, depth - 0.5, 0.5 - away), np.float32)


def grow(mask: Bytes, px: float) -> Bytes:
    """Return the mask of all that lies within `px` of the area; a negative `px` shrinks it, from its edge only."""
    return _antialiased(distance_inside(mask) + np.float32(px))


def smooth(mask: Bytes, px: float) -> Bytes:
    """Return the mask with its outline smoothed over `px`: where a Gaussian of that deviation leaves over half."""
    if px <= 0:
        return mask
    area = (mask > MARKED).astype(np.float32)
    soft = np.asarray(cv2.GaussianBlur(area, (0, 0), px, borderType=cv2.BORDER_REPLICATE))
    return _antialiased(distance_inside(np.where(soft > 0.5, 255, 0).astype(np.uint8)))


def feather(mask: Bytes, px: float) -> Bytes:
    """Return the mask with a soft edge: a ramp from 0, `px` outside the outline, to 255, as far inside."""
    if px <= 0:
        return mask
    return np.asarray(np.rint(255 * np.clip(0.5 + distance_inside(mask) / (2 * px), 0, 1)), np.uint8)


def fill_holes(mask: Bytes) -> Bytes:
    """Return the mask with all that the area encloses."""
    filled = scipy.ndimage.binary_fill_holes(mask > MARKED)
    return np.where(filled & (mask <= MARKED), 255, mask).astype(np.uint8)


def _antialiased(distance: Singles) -> Bytes:
    """Return a mask whose edge lies where `distance` is 0."""
    return np.asarray(np.rint(255 * np.clip(distance + 0.5, 0, 1)), np.uint8)
