"""The layers of a decomposed photo at every level of a pyramid, as the textures that cloth_layers.glsl reads."""

import moderngl
import numpy as np

from app.render import gpu
from app.render.programs import Names, programs_of
from app.render.sources.overlay_parameters import ClothParts
from app.render.sources.source import Box
from core import tracing
from core.arrays import Pixels
from core.imaging.images import Image
from core.overlay.composition import light_of

UNITS = {"coordinates": 0, "shading": 1, "detail": 2, "photo": 3, "coverage": 4}
"""Texture units; coarser levels have the coverage beside the coordinates."""
BAND_PIXELS = 1 << 20
"""So much of the photo is sent at a time to make a coarser level of."""
SWIZZLES = {1: "RRR1", 2: "RRRG", 3: "RGB1", 4: "RGBA"}
"""Grey in all colours, and alpha where there is none."""


class ClothLayers:
    """The textures of the window that was asked for last: the layers as they are, or their means from half size on."""

    def __init__(self, context: moderngl.Context, parts: ClothParts, photo: Image) -> None:
        self.middle = parts.middle
        self.usual_light = light_of(parts.shading)
        self._context, self._programs = context, programs_of(context)
        self._parts, self._photo = parts, photo
        self._window: tuple[Box, int] | None = None
        self.textures: list[moderngl.Texture] = []
        """In the order of `UNITS`."""

    def use(self, box: Box, base: int) -> Names:
        """Bind the textures of the source pixels of `box` at a level, cut at the picture's border.

        Return what cloth_layers.glsl must have defined to read them.
        """
        if self._window != (box, base):
            self.release()
            with tracing.span("upload", what="cloth"):
                self.textures = self._sent(box) if base == 0 else self._averaged(box, base)
            self._window = box, base
        return self._bind(self.textures)

    def _bind(self, textures: list[moderngl.Texture]) -> Names:
        for unit, texture in enumerate(textures):
            texture.use(unit)
        return ("RAW",) if len(textures) == len(UNITS) else ()

    def _sent(self, box: Box) -> list[moderngl.Texture]:
        """Send the layers of the pixels of `box` as they are."""
        parts, photo, textures = self._parts, self._photo.pixels, []
        for layer in (parts.uv, parts.shading, parts.detail, photo, parts.coverage):
            part: Pixels = np.ascontiguousarray(layer[box[1] : box[3], box[0] : box[2]])
            height, width, channels = (*part.shape, 1)[:3]
            dtype = {"u1": "f1", "u2": "nu2", "f4": "f4"}[part.dtype.str[1:]]
            texture = self._context.texture((width, height), channels, part, dtype=dtype, alignment=1)
            if layer is not parts.uv:
                texture.swizzle = SWIZZLES[channels]
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            textures.append(texture)
        return textures

    def _averaged(self, box: Box, base: int) -> list[moderngl.Texture]:
        """Send the layers band by band, and return the means of blocks of 2^base x 2^base of their pixels."""
        left, top, right, bottom = box[0], box[1], min(box[2], self._photo.width_px), min(box[3], self._photo.height_px)
        block = 1 << base
        out = self._targets(-(-(right - left) // block), -(-(bottom - top) // block))
        rows = max(BAND_PIXELS // (right - left) // block, 1)
        for first in range(0, out[0].height, rows):
            band = left, top + first * block, right, min(top + (first + rows) * block, bottom)
            textures = self._sent(band)
            for level in range(1, base + 1):
                width, height = (-(-side // 2) for side in textures[0].size)
                coarser = out if level == base else self._targets(width, height)
                self._halve(textures, coarser, (0, first if level == base else 0, width, height))
                gpu.release(*textures)
                textures = coarser
        return out

    def _targets(self, width: int, height: int) -> list[moderngl.Texture]:
        """Return textures of the layers of a coarser level; half precision is enough for all but the coordinates."""
        return [self._context.texture((width, height), 4, dtype=dtype) for dtype in ("f4", "f2", "f2", "f2")]

    def _halve(self, finer: list[moderngl.Texture], coarser: list[moderngl.Texture], part: gpu.Rectangle) -> None:
        """Draw means of blocks of 2 x 2 into a part of the textures of a coarser level."""
        framebuffer = self._context.framebuffer(coarser)
        with gpu.drawing(framebuffer, part):
            self._programs.fullscreen(
                "halve_cloth.frag", self._bind(finer), first_row=part[1], linear=self._photo.linear, **UNITS
            )
        framebuffer.release()

    def release(self) -> None:
        """Free the textures."""
        gpu.release(*self.textures)
        self.textures, self._window = [], None
