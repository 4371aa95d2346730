"""Masks that a picture holds itself: its transparency, its labels or its brightness."""

from weakref import WeakKeyDictionary

import cv2
import numpy as np

from core.arrays import Bytes, InputError
from core.imaging import color
from core.imaging.image import Image

MARKED = 127
MOST_LABELS = 32
"""So many grey levels at most, none of them over 127, make a picture of labels."""

_seen: WeakKeyDictionary[Image, bool] = WeakKeyDictionary()


def opacity(image: Image) -> Bytes:
    """Return the alpha (H, W) of a picture, 0 to 255; raise `InputError` where it has none, or the same all over."""
    if not has_transparency(image):
        raise InputError("the picture has no transparency to tell objects by")
    return np.asarray(color.quantise(color.unit(image.pixels[..., -1:]), np.uint8)[..., 0], np.uint8)


def has_transparency(image: Image) -> bool:
    """Return whether some of the picture is more transparent than some other part; looked up once for a picture."""
    if image not in _seen:
        _seen[image] = image.has_alpha and bool(image.pixels[..., -1].min() != image.pixels[..., -1].max())
    return _seen[image]


def opaque_under(image: Image, painted: Bytes) -> Bytes:
    """Return the opacity (H, W) of the parts of a picture that hang together and that somebody has painted over (H, W).

    Raises `InputError` where nothing opaque is painted over.
    """
    alpha = opacity(image)
    _, parts = cv2.connectedComponents((alpha > MARKED).astype(np.uint8), connectivity=8)
    touched = np.setdiff1d(parts[painted > MARKED], [0])
    if not touched.size:
        raise InputError("nothing is painted over but what is transparent")
    # The soft edge beside a part is its own.
    near = cv2.dilate(np.isin(parts, touched).astype(np.uint8), np.ones((3, 3), np.uint8))
    return np.where(near > 0, alpha, 0).astype(np.uint8)


def labels_in(mask: Bytes) -> Bytes | None:
    """Return the labels (H, W) that a grey picture (H, W) holds, numbered 1, 2, … by their levels; None for no labels.

    Labels are few small numbers beside 0: none is over 127, so that as a mask the picture would mark nothing.
    """
    if mask.max(initial=0) > MARKED:
        return None
    levels = np.unique(mask)
    if len(levels) < 2 or len(levels) > MOST_LABELS or levels[0] != 0:
        return None
    return np.asarray(np.searchsorted(levels, mask), np.uint8)
