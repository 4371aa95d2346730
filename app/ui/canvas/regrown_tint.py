"""What Retexture mode tints: where texture is regrown, with what the artist has painted over it."""

import numpy as np

from core.arrays import Bytes
from core.rasters.raster import Box, Raster
from core.retexture.region import ASKED, REFUSED


class RegrownTint:
    """Keeps the tint of the frame before, so that a stroke makes only those tiles anew that it touches."""

    def __init__(self) -> None:
        self._blank = self._regrown = self._painted = self._tint = Raster.filled(1, 1)

    def of(self, regrown: Raster | None, painted: Raster | None) -> Raster | None:
        """Return what is `regrown`, and more or less of it where that is `painted` (see `Document.regrow`)."""
        if painted is None:
            return regrown
        size = painted.width_px, painted.height_px
        if _size(self._tint) != size:
            self._blank = self._regrown = self._painted = self._tint = Raster.filled(*size)
        if regrown is None or _size(regrown) != size:
            regrown = self._blank
        if regrown is not self._regrown or painted is not self._painted:
            self._tint = regrown.edited((0, 0, *size), lambda tile, at: self._tile(tile, painted.tile_at(at), at))
            self._regrown, self._painted = regrown, painted
        return self._tint

    def _tile(self, regrown: Bytes, painted: Bytes, at: Box) -> Bytes:
        """Return a tile of the tint, the one of the frame before if both tiles are those."""
        if regrown is self._regrown.tile_at(at) and painted is self._painted.tile_at(at):
            return self._tint.tile_at(at)
        return np.where(painted > ASKED, 255, np.where(painted < REFUSED, 0, regrown)).astype(np.uint8)


def _size(raster: Raster) -> tuple[int, int]:
    return raster.width_px, raster.height_px
