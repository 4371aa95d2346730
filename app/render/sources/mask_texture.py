"""The mask on the GPU; only tiles that changed are sent."""

import cv2
import moderngl
import numpy as np

from core.arrays import Bytes
from core.rasters.raster import TILE_PX, Raster

MOST_SIDE_PX = 8192
"""Masks of larger pictures are kept smaller: the tint needs no more."""


class MaskTexture:
    """One texture of bytes, as large as the picture or a power of two smaller."""

    def __init__(self, context: moderngl.Context, mask: Raster) -> None:
        self._shrink = 1
        while max(mask.width_px, mask.height_px) > MOST_SIDE_PX * self._shrink and self._shrink < TILE_PX:
            self._shrink *= 2
        self.size_px = (mask.width_px, mask.height_px)
        size = (-(-mask.width_px // self._shrink), -(-mask.height_px // self._shrink))
        self.texture = context.texture(size, 1, alignment=1)
        self.texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self.texture.repeat_x = self.texture.repeat_y = False
        self._seen: Raster | None = None

    def update(self, mask: Raster) -> None:
        """Send what of `mask` is not there yet."""
        if mask is self._seen:
            return
        for box, tile in mask.changed_boxes(self._seen):
            small = self._reduced(tile)
            corner = (box[0] // self._shrink, box[1] // self._shrink)
            self.texture.write(np.ascontiguousarray(small), viewport=(*corner, small.shape[1], small.shape[0]))
        self._seen = mask

    def _reduced(self, tile: Bytes) -> Bytes:
        if self._shrink == 1:
            return tile
        size = (-(-tile.shape[1] // self._shrink), -(-tile.shape[0] // self._shrink))
        return np.asarray(cv2.resize(tile, size, interpolation=cv2.INTER_AREA), np.uint8)

    def release(self) -> None:
        """Free the texture."""
        self.texture.release()
