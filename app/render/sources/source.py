"""The source picture on the GPU: linear light, premultiplied, as a mip-mapped window of the picture's pyramid.

Level L of the pyramid averages blocks of 2^L x 2^L pixels, aligned at the picture's first pixel, its border repeated
outwards to whole blocks. A texture holds a window of it: the levels from `base` up, over a box of the picture that is
aligned to the coarsest block. The base level lies at the left, the coarser ones below one another at its right: one
plain texture, half as wide again, filled from means taken in float32. Level 0 of an 8-bit picture may be a texture of
its own instead, of the picture's own bytes, which shaders decode: a quarter to a half of what is read and sent. Because
blocks are aligned, every window has the same texels as the whole; so a picture too large for a texture or for the
memory is drawn window by window, with the same result.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import moderngl
import numpy as np

from app.render.gpu import release
from app.render.programs import Names
from app.render.sources.texels import bytes_of, halves, light_of, reduce, texels_of
from core import tracing
from core.imaging.images import Image
from core.imaging.set_aside import let_go

PICTURE_UNIT, ENCODED_UNIT = 2, 5
"""Texture units."""
TEXEL_BYTES = {"f1": 4, "f2": 8, "f4": 16}
LEVELS = 6
"""Levels above the base, where the picture is large enough to have them."""
PART_PIXELS = 1 << 18
GLIMPSE_TEXELS = 1 << 18
GLIMPSE_SIDE_PX = 1 << 12
"""A picture is shown by so many texels at most until it is loaded."""

Box = tuple[int, int, int, int]
"""left, top, right, bottom in source pixels; right and bottom are outside."""


@dataclass(frozen=True)
class TextureLimits:
    """What a texture may take at most."""

    side_px: int = 1 << 16
    budget_bytes: int = 132_000_000
    """A whole picture may take so much; a window half, since drivers let go of the one before late."""


DEFAULT_LIMITS = TextureLimits()


@dataclass(frozen=True)
class Window:
    """A part of the pyramid in a texture."""

    texture: moderngl.Texture
    box: Box
    base: int
    top: int
    """The coarsest level."""
    encoded: moderngl.Texture | None = None
    """Level 0 as bytes, encoded and straight; `texture` then has the coarser ones only."""

    def use(self) -> None:
        """Bind what filter.glsl reads."""
        self.texture.use(PICTURE_UNIT)
        if self.encoded is not None:
            self.encoded.use(ENCODED_UNIT)

    def names(self, base: int, top: int | None) -> Names:
        """Return what is to be defined in filter.glsl where levels from `base` up to `top` are read."""
        return () if self.encoded is None or base else ("ENCODED",) if top == 0 else ("ENCODED", "COARSER")

    @property
    def coarser_left(self) -> int:
        """The first column of the texture that has the coarser levels."""
        return self.base_size[0] if self.encoded is None else 0

    @property
    def base_size(self) -> tuple[int, int]:
        """Width and height of the base level, in texels."""
        return (self.box[2] - self.box[0]) >> self.base, (self.box[3] - self.box[1]) >> self.base

    def holds(self, box: Box, base: int, top: int) -> bool:
        """Return whether the window covers `box` from level `base` or finer to `top` or coarser."""
        inside = self.box[0] <= box[0] and self.box[1] <= box[1] and self.box[2] >= box[2] and self.box[3] >= box[3]
        return inside and self.base <= base and top <= self.top


@dataclass(frozen=True)
class _Coming:
    """A window, and what sends its pieces to the GPU."""

    window: Window
    pieces: Iterator[int]
    """Counts what is left."""


class Source:
    """A picture for drawing from: gives the window that a draw needs, and keeps the last one.

    `exact` keeps 16-bit and float pictures in float32, and level 0 of an 8-bit one as bytes. `margin` is by how much a
    window reaches beyond what is asked for, on each side, as a share of its size: for a view that moves about.
    """

    def __init__(
        self,
        context: moderngl.Context,
        image: Image,
        *,
        exact: bool = False,
        limits: TextureLimits = DEFAULT_LIMITS,
        margin: float = 0.0,
    ) -> None:
        self._context = context
        self.image = image
        self.dtype = "f4" if exact and image.pixels.dtype != np.uint8 else "f2"
        self._encodes = exact and image.pixels.dtype == np.uint8 and not image.linear
        self._budget_bytes = limits.budget_bytes
        self._max_side_px = min(limits.side_px, int(context.info["GL_MAX_TEXTURE_SIZE"]))
        self._margin = margin
        self._window: Window | None = None
        self._textures: dict[str, moderngl.Texture] = {}
        self._coming: _Coming | None = None
        self._glimpse: Window | None = None

    @cached_property
    def levels(self) -> int:
        """Number of levels above the base, whatever the base is."""
        return min(LEVELS, max(self.image.width_px, self.image.height_px).bit_length() - 1)

    @property
    def whole(self) -> Box:
        """The box of the whole picture."""
        return 0, 0, self.image.width_px, self.image.height_px

    def _bytes_per_texel(self, base: int, top: int) -> float:
        """Return what a texel of the base level takes, its share of the levels up to `top` included."""
        light = TEXEL_BYTES[self.dtype]
        if self._encodes and base == 0:
            return TEXEL_BYTES["f1"] + (light / 2 if top else 0)
        return light * 4 / 3

    def fits(self, box: Box, base: int, top: int | None = None) -> bool:
        """Return whether a window over `box` from level `base` to `top` is within the budget and the texture limit."""
        top = self._top(base, top)
        left, upper, right, lower = self._aligned(box, top)
        width, height = (right - left) >> base, (lower - upper) >> base
        sides_fit = max(width + coarser_width(width), height) <= self._max_side_px
        budget = self._budget_bytes // (1 if box == self.whole else 2)
        return sides_fit and width * height * self._bytes_per_texel(base, top) <= budget

    @property
    def is_small(self) -> bool:
        """Whether all of the picture fits, so that nobody need ask what is read."""
        return self.fits(self.whole, 0)

    def window(self, box: Box, base: int, top: int | None = None) -> Window:
        """Return a window over `box` with the levels from `base` to `top`, if not given all; the whole where that fits.

        A base that does not fit is raised to the least one that does: the drawing is then less sharp.
        """
        for _ in self.loading(box, base, top):
            pass
        assert self._window is not None
        return self._window

    def holds(self, box: Box, base: int, top: int | None = None) -> bool:
        """Return whether `window` need not load anything."""
        return self._window is not None and self._window.holds(*self._attainable(box, base, top))

    def loading(self, box: Box, base: int, top: int | None = None) -> Iterator[None]:
        """Load what `window` needs, piece by piece with a stop after each; what was begun for it goes on."""
        if self.holds(box, base, top):
            return
        box, base, top = self._attainable(box, base, top)
        coming = self._coming
        if coming is None or not coming.window.holds(box, base, top):
            least = 0 if self._encodes and top == 0 else None
            wishes = [(self.whole, 0, least), (self.whole, base, None), (self._with_margin(box), base, top)]
            coming = self._coming = self._begun(*next((wish for wish in wishes if self.fits(*wish)), (box, base, top)))
            yield  # making the texture may take as long as many pieces
        while self._coming is coming:
            if next(coming.pieces) == 0:
                self._window, self._coming = coming.window, None
            yield

    def glimpse(self, box: Box, base: int, top: int | None = None) -> Window:
        """Return the window over `box` if it is loaded, else one of the whole picture with few texels."""
        if self._window is not None and self.holds(box, base, top):
            return self._window
        if self._glimpse is None:
            self._glimpse = self._few_texels()
        return self._glimpse

    def _attainable(self, box: Box, base: int, top: int | None) -> tuple[Box, int, int]:
        """Return what there is of `box`, the least level from `base` up that fits, and the coarsest one."""
        box = self._clipped(box)
        while not (self.fits(box, base, top) or self.fits(self.whole, base)):
            base += 1
        return box, base, self._top(base, top)

    def _top(self, base: int, top: int | None) -> int:
        """Return the coarsest level that there is in a window from `base` up of which `top` is wished for."""
        most = base + self.levels
        return most if top is None else min(max(top, base), most)

    def release(self) -> None:
        """Free the GPU objects."""
        release(*self._textures.values())
        self._textures, self._window, self._coming = {}, None, None
        if self._glimpse is not None:
            self._glimpse.texture.release()
            self._glimpse = None

    def _with_margin(self, box: Box) -> Box:
        across, down = round((box[2] - box[0]) * self._margin), round((box[3] - box[1]) * self._margin)
        return self._clipped((box[0] - across, box[1] - down, box[2] + across, box[3] + down))

    def _clipped(self, box: Box) -> Box:
        left, top = max(box[0], 0), max(box[1], 0)
        left, top = min(left, self.image.width_px - 1), min(top, self.image.height_px - 1)
        return (
            left,
            top,
            max(min(box[2], self.image.width_px), left + 1),
            max(min(box[3], self.image.height_px), top + 1),
        )

    @staticmethod
    def _aligned(box: Box, level: int) -> Box:
        """Return the whole texels of `level` around `box`."""
        block = 1 << level
        left, top = box[0] // block * block, box[1] // block * block
        return left, top, -(-box[2] // block) * block, -(-box[3] // block) * block

    def _begun(self, box: Box, base: int, top: int | None) -> "_Coming":
        """Begin to load a window, in the place of the present one."""
        top = self._top(base, top)
        left, upper, right, lower = box = self._aligned(box, top)
        width, height = (right - left) >> base, (lower - upper) >> base
        self._window = None
        if self._encodes and base == 0:
            encoded = self._texture_of("f1", width, height)
            texture = self._texture_of(self.dtype, *((coarser_width(width), height) if top else (1, 1)))
        else:
            encoded, texture = None, self._texture_of(self.dtype, width + coarser_width(width), height)
        return _Coming(window := Window(texture, box, base, top, encoded), self._pieces(window))

    def _pieces(self, window: Window) -> Iterator[int]:
        """Send the pyramid to the texture of `window`; count the pieces that are left."""
        (first_x, first_y, *_), base, size = window.box, window.base, window.base_size
        first = 0 if window.encoded is None else 1
        parts = list(_parts(window.box, 1 << window.top))
        for left, part in zip(reversed(range(len(parts))), parts, strict=True):
            with tracing.span("upload", what="picture"):
                x, y = (part[0] - first_x) >> base, (part[1] - first_y) >> base
                if window.encoded is not None:
                    window.encoded.write(bytes_of(self.image, part), (x, y, part[2] - part[0], part[3] - part[1]))
                if window.top - base >= first:
                    texels = reduce(texels_of(self.image, part), 1 << base)
                let_go(self.image.pixels)
                for level in range(first, window.top - base + 1):
                    texels = reduce(texels, 2) if level else texels
                    shift = (window.coarser_left, size[1] - (size[1] >> (level - 1))) if level else (0, 0)
                    corner = ((x >> level) + shift[0], (y >> level) + shift[1])
                    sent = texels if self.dtype == "f4" else halves(texels)
                    window.texture.write(sent, viewport=(*corner, texels.shape[1], texels.shape[0]))
            yield left

    def _few_texels(self) -> Window:
        """Return a window of one level that takes single pixels of the picture, at the middle of its texels."""
        width, height = self.image.size_px
        base = 0
        while (width >> base) * (height >> base) > GLIMPSE_TEXELS or max(width, height) >> base > GLIMPSE_SIDE_PX:
            base += 1
        step = 1 << base
        first_row, first_column = min(step // 2, height - 1), min(step // 2, width - 1)
        light = light_of(self.image, np.ascontiguousarray(self.image.pixels[first_row::step, first_column::step]))
        let_go(self.image.pixels)
        size = light.shape[1], light.shape[0]
        texture = self._context.texture(size, 4, np.ascontiguousarray(halves(light)), dtype="f2")
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        return Window(texture, (0, 0, size[0] << base, size[1] << base), base, base)

    def _texture_of(self, dtype: str, width: int, height: int) -> moderngl.Texture:
        """Return a texture of at least this size: the present one if that will do, since drivers free late."""
        held = self._textures.get(dtype)
        if held is not None and held.width >= width and held.height >= height:
            return held
        if held is not None:
            larger = max(held.width, width), max(held.height, height)
            if larger[0] * larger[1] * TEXEL_BYTES[dtype] <= self._budget_bytes // 2:
                width, height = larger
            held.release()
        texture = self._textures[dtype] = self._context.texture((width, height), 4, dtype=dtype)
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        return texture


def coarser_width(width: int) -> int:
    """Return how many columns the coarser levels take beside a base level of so many."""
    return max(width // 2, 1)


def _parts(box: Box, block: int) -> Iterator[Box]:
    """Cut `box` into parts of whole blocks, small enough to work on."""
    left, top, right, bottom = box
    width = max(PART_PIXELS // block // block, 1) * block
    height = max(PART_PIXELS // min(width, right - left) // block, 1) * block
    for y in range(top, bottom, height):
        for x in range(left, right, width):
            yield x, y, min(x + width, right), min(y + height, bottom)
