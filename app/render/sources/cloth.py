"""A photo with a new texture in its folds, as a source to draw from: composed on the GPU whenever anything changes."""

from collections.abc import Iterator
from dataclasses import replace

import cv2
import moderngl
import numpy as np

from app.render import gpu
from app.render.programs import programs_of
from app.render.sources.cloth_layers import ClothLayers
from app.render.sources.overlay_parameters import ClothParts, OverlayParameters
from app.render.sources.source import Box, Source, TextureLimits, Window
from core.arrays import Floats
from core.imaging.images import Image
from core.overlay.composition import prepare, with_opacity
from core.overlay.filters.texture_filter import DENSITY, TAPS, halve
from core.overlay.laying.compositing import texture_colours

LIMITS = TextureLimits(budget_bytes=64_000_000)
"""The layers take five times as much."""
PATTERN_UNIT = 4
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
        box = self._clipped(box)
        if self._window is not None and self._window.holds(box, base, self._top(base, top)):
            return self._window
        wide = self._with_margin(box)
        while not self.fits(wide, base):
            base += 1
        return self._load(wide, base)

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
        self._layers.use(box, base, 0)
        self._pattern.use(worn, PATTERN_UNIT)
        with self._composed.drawing():
            self._programs.fullscreen(
                "cloth.frag",
                coordinates=0,
                shading=1,
                detail=2,
                photo=3,
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
        before = self._texture
        texture = self._texture_of(size[0] + max(size[0] // 2, 1), size[1])
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
        self._seen: OverlayParameters | None = None
        self._source: tuple[Image, Floats] | None = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in samples, mirror images included."""
        assert self._texture is not None
        return self._texture.width, self._texture.height

    def use(self, worn: OverlayParameters, unit: int) -> None:
        """Bind the pattern of `worn`."""
        if self._texture is None or not _same_samples(worn, self._seen):
            self._send(prepare(self._colours(worn.texture), worn.placement, worn.parts.basis))
            self._seen = worn
        assert self._texture is not None
        self._texture.use(unit)

    def _colours(self, texture: Image) -> Floats:
        """Return the texture (h, w, 4) as its file has it."""
        if self._source is None or self._source[0] is not texture:
            self._source = texture, with_opacity(texture_colours(texture))
        return self._source[1]

    def _send(self, samples: Floats) -> None:
        longest = max(samples.shape[:2])
        if longest > MOST_PATTERN_PX:
            shrink = MOST_PATTERN_PX / longest
            size = [max(1, round(side * shrink)) for side in samples.shape[1::-1]]
            samples = np.asarray(cv2.resize(samples, size, interpolation=cv2.INTER_AREA), np.float64)
        levels = [samples]
        while max(levels[-1].shape[:2]) > 1:
            levels.append(halve(levels[-1]))
        self.release()
        self._texture = self._context.texture((samples.shape[1], samples.shape[0]), 4, dtype="f4")
        self._texture.build_mipmaps()
        for number, level in enumerate(levels):
            self._texture.write(np.ascontiguousarray(level, np.float32), level=number)
        self._texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        self._texture.repeat_x = self._texture.repeat_y = True

    def release(self) -> None:
        """Free the texture."""
        gpu.release(self._texture)
        self._texture = self._seen = None


def _same_samples(a: OverlayParameters, b: OverlayParameters | None) -> bool:
    """Return whether the pattern has the same samples in both."""
    if b is None or a.texture is not b.texture or a.parts is not b.parts:
        return False
    still = [replace(worn.placement, offset=(0.0, 0.0), tile=True) for worn in (a, b)]
    return still[0] == still[1]
