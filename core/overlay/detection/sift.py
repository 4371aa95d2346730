"""SIFT keypoints of a photo [Lowe 2004]."""

from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Bools, Bytes, Floats, Points, Singles
from core.overlay.filters.magnifying import LEAST_SIZE_PX, TIMES, can_be_magnified, enlarged, enlarged_mask
from core.overlay.filters.shrinking import to_small


@dataclass(frozen=True)
class Keypoints:
    """SIFT keypoints (n,)."""

    points: Points
    """(n, 2), pixels."""
    sizes: Floats
    """(n,), diameters, pixels."""
    turns: Floats
    """(n,), directions, radians from x to y."""
    descriptors: Singles
    """(n, 128), roots of histograms, of length one [Arandjelović and Zisserman 2012]."""

    def __getitem__(self, rows: Bools) -> "Keypoints":
        """Return some of them."""
        return Keypoints(self.points[rows], self.sizes[rows], self.turns[rows], self.descriptors[rows])


def detect_keypoints(image: Singles, valid: Bools, *, upright: bool = False) -> Keypoints:
    """Return the SIFT keypoints of an image (H, W, 3) in `valid`, or what they are as if none was turned: `upright`."""
    sift, levels = cv2.SIFT_create(nfeatures=4000, contrastThreshold=0.02), grey_levels(image, valid)  # type: ignore[attr-defined]
    found = sift.detect(levels, valid.astype(np.uint8))
    if not found:  # OpenCV fails at describing none in a picture of one pixel.
        return Keypoints(np.empty((0, 2)), np.empty(0), np.empty(0), np.empty((0, 128), np.float32))
    if upright:
        for keypoint in found:
            keypoint.angle = 0.0
    found, histograms = sift.compute(levels, found)
    points, sizes, angles = (
        np.array([getattr(k, name) for k in found], np.float64) for name in ("pt", "size", "angle")
    )
    descriptors = np.asarray(histograms, np.float32)
    roots = np.sqrt(descriptors / np.maximum(descriptors.sum(1, keepdims=True), 1e-9))
    return Keypoints(points, sizes, np.deg2rad(angles), np.asarray(roots, np.float32))


def grey_levels(image: Singles, valid: Bools) -> Bytes:
    """Return the grey of an image (H, W, 3), 0 to 255 between the least and the greatest that are usual in `valid`."""
    grey = image.mean(-1)
    low, high = np.percentile(grey[valid], (1, 99)) if valid.any() else (0.0, 1.0)
    return np.asarray(np.clip(255 * (grey - low) / max(float(high - low), 1e-6), 0, 255), np.uint8)


def detect_fine_keypoints(image: Singles, valid: Bools) -> Keypoints:
    """Return the SIFT keypoints of an image (H, W, 3) in `valid`; a small one is enlarged to tell them."""
    if not can_be_magnified(valid.shape):
        return detect_keypoints(image, valid)
    large = detect_keypoints(enlarged(image), enlarged_mask(valid))
    found = large[large.sizes >= TIMES * LEAST_SIZE_PX]
    return Keypoints(to_small(found.points, TIMES), found.sizes / TIMES, found.turns, found.descriptors)
