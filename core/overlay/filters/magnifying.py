"""Small photos enlarged: what repeats by a few pixels, or has motifs of a few, is told by less than one."""

import cv2
import numpy as np

from core.arrays import Bools
from core.overlay.filters.texture_filter import F

TIMES = 2
LONGEST_PX = 1200
"""Longest side of an enlarged photo: a search takes time as its pixels do."""
LEAST_SIZE_PX = 1.2
"""Diameter of keypoints of an enlarged photo, in its own pixels: smaller ones tell of noise and interpolation."""


def can_be_magnified(shape: tuple[int, int]) -> bool:
    """Return whether a photo (H, W) is so small that it is searched enlarged."""
    return TIMES * max(shape) <= LONGEST_PX


def enlarged(picture: F) -> F:
    """Return a picture (H, W, 3) `TIMES` as large, by cubic interpolation."""
    size = TIMES * picture.shape[1], TIMES * picture.shape[0]
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_CUBIC), picture.dtype)


def enlarged_mask(mask: Bools) -> Bools:
    """Return a mask (H, W) `TIMES` as large."""
    return np.repeat(np.repeat(mask, TIMES, 0), TIMES, 1)
