"""The source picture on the GPU: linear light, premultiplied, as a mip-mapped window of the picture's pyramid.

Level L of the pyramid averages blocks of 2^L x 2^L pixels, aligned at the picture's first pixel, its border repeated
outwards to whole blocks. A texture holds a window of it: the levels from `base` up, over a box of the picture that is
aligned to the coarsest block. Because blocks are aligned, every window has the same texels as the whole; so a picture
too large for a texture or for the memory is drawn window by window, with the same result.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import moderngl
import numpy as np
from numpy.typing import DTypeLike

from core import color
from core.arrays import Pixels, Singles
from core.images import Image

LEVELS = 6
"""Levels above the base, where the picture is large enough to have them."""
BAND_PIXELS = 1 << 19

Box = tuple[int, int, int, int]
"""left, top, right, bottom in source pixels; right and bottom are outside."""


@dataclass(frozen=True)
class Limits:
    """What a texture may take at most."""

    side_px: int = 1 << 16
    budget_bytes: int = 160_000_000


DEFAULT_LIMITS = Limits()


@dataclass(frozen=True)
class Window:
    """A part of the pyramid in a texture."""

    texture: moderngl.Texture
    box: Box
    base: int
    top: int

    def holds(self, box: Box, base: int) -> bool:
        """Return whether the window covers `box` from level `base` or finer."""
        inside = self.box[0] <= box[0] and self.box[1] <= box[1] and self.box[2] >= box[2] and self.box[3] >= box[3]
        return inside and self.base <= base


class Source:
    """A picture for drawing from: gives the window that a draw needs, and keeps the last one."""

    def __init__(
        self,
        context: moderngl.Context,
        image: Image,
        *,
        exact: bool = False,
        limits: Limits = DEFAULT_LIMITS,
    ) -> None:
        self._context = context
        self.image = image
        self.dtype = "f4" if exact and image.pixels.dtype != np.uint8 else "f2"
        self._budget_bytes = limits.budget_bytes
        self._max_side_px = min(limits.side_px, int(context.info["GL_MAX_TEXTURE_SIZE"]))
        self._window: Window | None = None

    @cached_property
    def levels(self) -> int:
        """Number of levels above the base, whatever the base is."""
        return min(LEVELS, max(self.image.width_px, self.image.height_px).bit_length() - 1)

    @property
    def whole(self) -> Box:
        """The box of the whole picture."""
        return 0, 0, self.image.width_px, self.image.height_px

    def fits(self, box: Box, base: int) -> bool:
        """Return whether a window over `box` from level `base` is within the budget and the texture limit."""
        left, top, right, bottom = self._aligned(box, base)
        width, height = (right - left) >> base, (bottom - top) >> base
        texel_bytes = 16 if self.dtype == "f4" else 8
        return max(width, height) <= self._max_side_px and width * height * texel_bytes * 4 // 3 <= self._budget_bytes

    def window(self, box: Box, base: int) -> Window:
        """Return a window over `box` with levels from `base` up; the whole picture where that fits.

        A base that does not fit is raised to the least one that does: the drawing is then less sharp.
        """
        box = self._clipped(box)
        if self._window is not None and self._window.holds(box, base):
            return self._window
        self.release()
        for wish, level in [(self.whole, 0), (self.whole, base), (box, base)]:
            if self.fits(wish, level):
                return self._load(wish, level)
        while not self.fits(box, base):
            base += 1
        return self._load(box, base)

    def release(self) -> None:
        """Free the texture."""
        if self._window is not None:
            self._window.texture.release()
            self._window = None

    def _clipped(self, box: Box) -> Box:
        left, top = max(box[0], 0), max(box[1], 0)
        left, top = min(left, self.image.width_px - 1), min(top, self.image.height_px - 1)
        return (
            left,
            top,
            max(min(box[2], self.image.width_px), left + 1),
            max(min(box[3], self.image.height_px), top + 1),
        )

    def _aligned(self, box: Box, base: int) -> Box:
        block = 1 << (base + self.levels)
        left, top = box[0] // block * block, box[1] // block * block
        return left, top, -(-box[2] // block) * block, -(-box[3] // block) * block

    def _load(self, box: Box, base: int) -> Window:
        left, top, right, bottom = self._aligned(box, base)
        size = ((right - left) >> base, (bottom - top) >> base)
        texture = self._context.texture(size, 4, dtype=self.dtype)
        for y, rows in self._bands((left, top, right, bottom), base):
            texture.write(rows.tobytes(), viewport=(0, y, size[0], len(rows)))
        if self.levels:
            texture.build_mipmaps(0, self.levels)
        texture.filter = (moderngl.NEAREST_MIPMAP_NEAREST if self.levels else moderngl.NEAREST, moderngl.NEAREST)
        self._window = Window(texture, (left, top, right, bottom), base, base + self.levels)
        return self._window

    def _bands(self, box: Box, base: int) -> Iterator[tuple[int, Pixels]]:
        """Yield the rows of level `base` inside `box`, a few at a time: (first row, (h, w, 4))."""
        left, top, right, bottom = box
        block = 1 << base
        step = max(BAND_PIXELS // (right - left), 1) * block
        step = min(step, max(block, (1 << 24) // (right - left) // block * block))
        for y in range(top, bottom, step):
            end = min(y + step, bottom)
            texels = _texels(self.image, (left, y, right, end), self.dtype)
            yield (y - top) >> base, _reduced(texels, block)


def _texels(image: Image, box: Box, dtype: DTypeLike) -> Pixels:
    """Return the premultiplied linear light of `box`, the picture's border repeated outwards: (h, w, 4)."""
    left, top, right, bottom = box
    height, width = image.height_px, image.width_px
    rows = slice(min(top, height - 1), min(bottom, height))
    columns = slice(min(left, width - 1), min(right, width))
    light = color.premultiply(color.linear_light(image.pixels[rows, columns], linear=image.linear))
    filled = np.empty((bottom - top, right - left, 4), dtype)
    shown = filled[: light.shape[0], : light.shape[1]]
    colors = color.color_channels(light.shape[2])
    shown[..., :3] = light[..., :colors]
    shown[..., 3] = light[..., -1] if light.shape[2] > colors else 1
    filled[: light.shape[0], light.shape[1] :] = shown[:, -1:]
    filled[light.shape[0] :] = filled[light.shape[0] - 1 : light.shape[0]]
    return filled


def _reduced(texels: Pixels, block: int) -> Pixels:
    """Return the means of blocks of `block` x `block` texels."""
    if block == 1:
        return texels
    height, width = texels.shape[0] // block, texels.shape[1] // block
    blocks: Singles = texels.reshape(height, block, width, block, 4).mean(axis=(1, 3), dtype=np.float32)
    return blocks.astype(texels.dtype)
