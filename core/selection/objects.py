"""An object that stands out in a box, without the specks that are told from the ground beside it."""

import cv2
import numpy as np

from core.arrays import Bytes, InputError, Points
from core.imaging.image import Image
from core.masks.object_masks import object_within
from core.progress import Job
from core.selection.features import MARKED
from core.selection.importance import groundness
from core.selection.refining import fill_holes
from core.selection.shapes import fill_polygon, rectangle_outline
from core.selection.sources import has_transparency, opaque_under

LEAST_PART = 0.05
"""Parts that are smaller than this share of the largest one are specks."""
LEAST_SHARE = 0.05
"""An object takes up so much of its box at least: who draws a box draws it around the object."""


def object_in_box(image: Image, low: Points, high: Points) -> Job[Bytes]:
    """Return the mask (H, W), 0 to 255, of the object in a box from `low` to `high` (2,), in pixels.

    On a picture with transparency that is what is opaque there. Raises `InputError` where nothing stands out.
    """
    if has_transparency(image):
        return opaque_under(image, fill_polygon(image.size_px, rectangle_outline(low, high)))
    low, high = np.maximum(low, -0.5), np.minimum(high, np.subtract(image.size_px, 0.5))
    reaches_border = bool((low < 0.5).any() or (high > np.subtract(image.size_px, 1.5)).any())
    ground = groundness(image) if reaches_border else None
    found = fill_holes((yield from object_within(image, low, high, ground)))
    count, parts, stats, _ = cv2.connectedComponentsWithStats((found > MARKED).astype(np.uint8), connectivity=8)
    areas = stats[1:count, cv2.CC_STAT_AREA]
    large = areas >= LEAST_PART * areas.max(initial=0)
    if areas[large].sum() < LEAST_SHARE * float(np.prod(np.subtract(high, low))):
        raise InputError("nothing stands out in the box: paint over the object instead")
    kept = np.isin(parts, 1 + np.flatnonzero(large)).astype(np.uint8)
    # The soft edge beside a part is its own.
    return np.where(cv2.dilate(kept, np.ones((3, 3), np.uint8)) > 0, found, 0).astype(np.uint8)
