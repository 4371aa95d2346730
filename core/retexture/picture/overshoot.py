"""Ringing: beside a strong edge a sharp kernel draws a dark rim and a bright one that the source does not show.

Between four pixels of the source a peak may lie that is darker, or brighter, than each of them, and fine texture is
duller without. It is seldom so by much; what goes farther is ringing, and is held.
"""

import cv2
import numpy as np

from core.arrays import Singles
from core.imaging import color
from core.retexture.sampling import Kernel, read

OVERSHOOT = 0.1
"""By how much, of encoded values from 0 to 1, a place may be darker or brighter than each of the four pixels around."""


class ColourLimits:
    """The least and the most that the four pixels around any place of a source (H, W, C) show."""

    def __init__(self, source: Singles, *, linear: bool) -> None:
        """`linear` says that the numbers of the source are no encoded light, as with `color.linear_light`."""
        four = np.ones((2, 2), np.uint8)
        self._linear = linear
        self._least = np.asarray(cv2.erode(source, four, anchor=(0, 0)), np.float32).reshape(source.shape)
        self._most = np.asarray(cv2.dilate(source, four, anchor=(0, 0)), np.float32).reshape(source.shape)

    def hold(self, light: Singles, at: Singles) -> None:
        """Hold what `light` (h, w, C) shows of the places `at` (h, w, 2), in place, to the four pixels around each."""
        corner, flat = np.floor(at), light.reshape(-1)
        for limit, sense in ((self._least, -1), (self._most, 1)):
            around = read(limit, corner, Kernel.NEAREST, mirror=True).reshape(-1)
            beyond = np.flatnonzero(flat < around if sense < 0 else flat > around)
            farthest = self._past(around.take(beyond), np.float32(sense * OVERSHOOT))
            flat[beyond] = (np.maximum if sense < 0 else np.minimum)(flat.take(beyond), farthest)

    def _past(self, light: Singles, by: np.float32) -> Singles:
        """Return `light` (n,) plus `by` of encoded values."""
        return light + by if self._linear else color.decode(color.encode(light) + by)
