"""A photo with a new texture in its folds, as a source to draw from: composed on the GPU whenever anything changes."""

from collections.abc import Iterator

import cv2
import moderngl
import numpy as np

from app.render import gpu
from app.render.programs import programs_of
from app.render.sources.cloth_layers import UNITS, ClothLayers
from app.render.sources.overlay_parameters import ClothParts, OverlayParameters
from app.render.sources.source import Box, Source, TextureLimits, Window, coarser_width
from core.arrays import Singles
from core.imaging.images import Image
from core.overlay.composition import count_samples, fit_samples, premultiply
from core.overlay.filters.texture_filter import DENSITY, TAPS, halve
from core.overlay.laying.compositing import single_colours

LIMITS = TextureLimits(budget_bytes=64_000_000)
"""The layers take five times as much."""
PATTERN_UNIT = 5
"""Texture unit after those of the layers."""
MOST_PATTERN_PX = 4096
DRAFT_TAPS = 2


class DressedSource(Source):
    """The photo `image` with a texture laid on; `dress` before drawing.

    A window is composed at the level of detail that the view needs.
    """

    def __init__(self, context: moderngl.Context, image: Image, parts: ClothParts) -> None:
        super().__init__(context, image, limits=LIMITS, margin=0.25)
        self.parts = parts
        self._programs = programs_of(context)
        self._layers = ClothLayers(context, parts, image)
        self._pattern = Pattern(context)
        self._composed: gpu.Offscreen | None = None
        self._pyramid: moderngl.Framebuffer | None = None
        self._worn: OverlayParameters | None = None
        self._is_draft = False

    def dress(self, overlay: OverlayParameters, *, draft: bool = False) -> None:
        """Lay the texture on, if it does not lie so already; a `draft` is less smooth where folds shrink it."""
        if not overlay.looks_like(self._worn) or (self._is_draft and not draft):
            self._window, self._is_draft = None, draft
        self._worn = overlay

    @property
    def is_small(self) -> bool:
        """Whether it would be no waste to compose the whole at full size: never."""
        return False

    def loading(self, box: Box, base: int, top: int | None = None) -> Iterator[None]:
        """Stop nowhere: `window` composes."""
        self.window(box, base, top)
        return iter(())

    def glimpse(self, box: Box, base: int, top: int | None = None) -> Window:
        """Return what `window` does."""
        return self.window(box, base, top)

    def window(self, box: Box, base: int, top: int | None = None) -> Window:
        """Return a window over `box` with all levels from `base` up."""
        if self._window is not None and self.holds(box, base, top):
            return self._window
        box, base, _ = self._attainable(box, base, None)
        wishes = self._with_margin(box), self.whole, box
        return self._load(next(wish for wish in wishes if self.fits(wish, base)), base)

    def release(self) -> None:
        """Free the GPU objects."""
        super().release()
        gpu.release(self._layers, self._pattern, self._composed, self._pyramid)
        self._composed = self._pyramid = None

    def _load(self, box: Box, base: int) -> Window:
        box = self._aligned(box, base + self.levels)
        size = ((box[2] - box[0]) >> base, (box[3] - box[1]) >> base)
        self._compose(box, base, size)
        texture = self._fill(size)
        self._window = Window(texture, box, base, base + self.levels)
        return self._window

    def _compose(self, box: Box, base: int, size: tuple[int, int]) -> None:
        """Compose the base level."""
        if self._composed is None or self._composed.size != size:
            gpu.release(self._composed)
            self._composed = gpu.Offscreen(self._context, size, self.dtype)
        worn = self._worn
        assert worn is not None
        placement = worn.placement
        matrix, shift = placement.affine(self.parts.basis, self._layers.middle)
        images = 2 if placement.mirror else 1
        defined = self._layers.use(box, base)
        self._pattern.use(worn, PATTERN_UNIT)
        with self._composed.drawing():
            self._programs.fullscreen(
                "cloth.frag",
                defined,
                **UNITS,
                pattern=PATTERN_UNIT,
                # GLSL has columns first.
                to_copies=tuple((matrix.T / images).ravel()),
                first_copy=tuple(shift / images),
                samples=tuple(np.array(self._pattern.size) / DENSITY),
                most_taps=DRAFT_TAPS if self._is_draft else TAPS,
                tiled=placement.tile,
                alpha=worn.detail,
                strength=worn.shading,
                usual_light=self._layers.usual_light,
                linear=self.image.linear,
            )

    def _fill(self, size: tuple[int, int]) -> moderngl.Texture:
        """Return the texture of the whole pyramid: the base at the left, coarser levels below one another beside it."""
        assert self._composed is not None
        before = self._textures.get(self.dtype)
        texture = self._texture_of(self.dtype, size[0] + coarser_width(size[0]), size[1])
        if texture is not before or self._pyramid is None:
            self._pyramid = self._context.framebuffer([texture])
        self._composed.texture.use(0)
        for level in range(self.levels + 1):
            corner = (size[0], size[1] - (size[1] >> (level - 1))) if level else (0, 0)
            with gpu.drawing(self._pyramid, (*corner, size[0] >> level, size[1] >> level)):
                self._programs.fullscreen("halve.frag", texels=0, origin=(0, 0), corner=corner, block=1 << level)
        return texture


class Pattern:
    """What is laid, as a mip-mapped texture that repeats; sent anew only where its samples change."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._texture: moderngl.Texture | None = None
        self._source: tuple[Image, Singles] | None = None
        self._sent: tuple[object, ...] = ()
        """Of what the texture holds the samples, and how many."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in samples, mirror images included."""
        assert self._texture is not None
        return self._texture.width, self._texture.height

    def use(self, worn: OverlayParameters, unit: int) -> None:
        """Bind the pattern of `worn`."""
        if self._source is None or self._source[0] is not worn.texture:
            self._source = worn.texture, premultiply(single_colours(worn.texture))
            self._sent = ()
        size = count_samples(worn.texture.size_px, worn.placement, worn.parts.basis)
        if self._sent != (size, worn.placement.mirror):
            self._send(fit_samples(self._source[1], worn.placement, worn.parts.basis))
            self._sent = size, worn.placement.mirror
        assert self._texture is not None
        self._texture.use(unit)

    def _send(self, samples: Singles) -> None:
        longest = max(samples.shape[:2])
        if longest > MOST_PATTERN_PX:
            shrink = MOST_PATTERN_PX / longest
            size = [max(1, round(side * shrink)) for side in samples.shape[1::-1]]
            samples = np.asarray(cv2.resize(samples, size, interpolation=cv2.INTER_AREA), np.float32)
        levels = [samples]
        while max(levels[-1].shape[:2]) > 1:
            levels.append(halve(levels[-1]))
        gpu.release(self._texture)
        self._texture = self._context.texture((samples.shape[1], samples.shape[0]), 4, dtype="f4")
        self._texture.build_mipmaps()
        for number, level in enumerate(levels):
            self._texture.write(np.ascontiguousarray(level), level=number)
        self._texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        self._texture.repeat_x = self._texture.repeat_y = True

    def release(self) -> None:
        """Free the texture."""
        gpu.release(self._texture)
        self._texture = self._source = None
        self._sent = ()
