"""A photo with a new texture in its cloth, as a source to draw from: composed on the GPU whenever a slider moves.

The parts of the photo are sent once, the texture's pyramid when the texture or its density changes; all else are
uniforms (cloth.frag).
"""

import moderngl
import numpy as np

from app.render import gpu
from app.render.dressing import ClothParts, Dressing
from app.render.programs import programs_of
from app.render.source import Box, Source, Window
from core import color
from core.arrays import Floats, Pixels, Singles
from core.images import Image
from core.overlay.composition import DENSITY, Placement, halved, thinned
from core.overlay.folder import encoded

MOST_LEVELS = 14
"""As in cloth.frag."""


class DressedSource(Source):
    """The photo `image` with a texture laid on; `dress` before drawing."""

    def __init__(self, context: moderngl.Context, image: Image, parts: ClothParts) -> None:
        super().__init__(context, image)
        self.parts = parts
        self._programs = programs_of(context)
        self._light = _PhotoLight(parts)
        self._photo = _texture(context, _straight(image), "f2")
        self._coordinates = _texture(context, self._light.coordinates, "f4")
        self._shading = _texture(context, self._light.shading, "f2")
        self._detail = _texture(context, _rgba(np.nan_to_num(parts.detail)), "f2")
        self._pattern: _Pattern | None = None
        self._worn: Dressing | None = None
        left, top, right, bottom = self._aligned(self.whole, 0)
        self._size = (right - left, bottom - top)
        self._pyramid = gpu.Offscreen(context, (self._size[0] + max(self._size[0] // 2, 1), self._size[1]), "f2")
        self._level = gpu.Offscreen(context, (max(self._size[0] // 2, 1), max(self._size[1] // 2, 1)), "f2")

    def dress(self, dressing: Dressing) -> None:
        """Lay the texture on, if it does not lie so already."""
        if dressing.looks_like(self._worn):
            return
        density = _density(dressing, self.parts.basis)
        key = (dressing.texture, dressing.placement.mirror, np.round(np.maximum(density / DENSITY, 1.0), 6).tolist())
        if self._pattern is None or not self._pattern.is_for(key):
            if self._pattern is not None:
                self._pattern.texture.release()
            self._pattern = _Pattern(self._context, key, density)
        self._compose(dressing, self._pattern)
        self._worn = dressing

    def window(self, box: Box, base: int) -> Window:
        """Return the whole."""
        return Window(self._pyramid.texture, self._aligned(self.whole, 0), 0, self.levels)

    @property
    def is_small(self) -> bool:
        """Whether all of it is there: always."""
        return True

    def release(self) -> None:
        """Free the textures."""
        super().release()
        for held in (self._photo, self._coordinates, self._shading, self._detail, self._pyramid, self._level):
            held.release()
        if self._pattern is not None:
            self._pattern.texture.release()
            self._pattern = None

    def _compose(self, dressing: Dressing, pattern: "_Pattern") -> None:
        """Draw the finest level, then each coarser one from the one before."""
        matrix, shift = self._light.map_of(dressing.placement, self.parts.basis)
        textures = (self._photo, self._coordinates, self._shading, self._detail, pattern.texture)
        with self._pyramid.drawing((0, 0, *self._size)):
            for unit, texture in enumerate(textures):
                texture.use(unit)
            self._programs.fullscreen(
                "cloth.frag",
                photo=0,
                coordinates=1,
                shading=2,
                detail=3,
                pattern=4,
                photo_size=(self.image.width_px, self.image.height_px),
                levels=pattern.levels,
                last_level=pattern.last_level,
                placement=tuple(matrix.T.ravel().tolist()),
                shift=tuple(shift.tolist()),
                mirror=dressing.placement.mirror,
                repeats=dressing.placement.tile,
                strength=dressing.shading,
                middle_light=self._light.middle_light,
                detail_share=dressing.detail,
                linear=self.image.linear,
            )
        self._halve()

    def _halve(self) -> None:
        width, height = self._size
        origin = (0, 0)
        for level in range(1, self.levels + 1):
            size = (width >> level, height >> level)
            with self._level.drawing((0, 0, *size)):
                self._pyramid.texture.use(0)
                self._programs.fullscreen("halve.frag", texels=0, origin=origin, corner=(0, 0), block=2)
            origin = (width, height - (height >> (level - 1)))
            with self._pyramid.drawing((*origin, *size)):
                self._level.texture.use(0)
                self._programs.fullscreen("halve.frag", texels=0, origin=(0, 0), corner=origin, block=1)


class _PhotoLight:
    """What of the parts does not change with the texture."""

    def __init__(self, parts: ClothParts) -> None:
        covered = np.asarray(np.isfinite(parts.uv).all(axis=-1))
        self.coordinates = np.concatenate(
            [np.nan_to_num(parts.uv), parts.coverage[..., None], covered[..., None]], axis=-1
        ).astype(np.float32)
        self.middle_light = float(np.nanmedian(parts.shading)) if covered.any() else 1.0
        self.shading = _rgba(np.nan_to_num(parts.shading))
        self._middle: Floats = np.median(parts.uv[covered], axis=0).astype(float) if covered.any() else np.zeros(2)

    def map_of(self, placement: Placement, basis: Floats) -> tuple[Floats, Floats]:
        """Return matrix (2, 2) and shift (2,) that take texels to copies of the texture."""
        shift = placement(np.zeros(2), basis, self._middle)
        return placement.matrix(basis), shift


class _Pattern:
    """The pyramid of a texture in one texture, the levels one below another."""

    def __init__(self, context: moderngl.Context, key: tuple[Image, bool, list[float]], density: Floats) -> None:
        self._key = key
        pyramid = _pyramid(key[0], density, mirror=key[1])
        self.last_level = len(pyramid) - 1
        width, height = pyramid[0].shape[1], sum(level.shape[0] for level in pyramid)
        self.texture = context.texture((width, height), 4, dtype="f2")
        self.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        places, y = [], 0
        for level in pyramid:
            h, w = level.shape[:2]
            self.texture.write(np.ascontiguousarray(level, np.float16), viewport=(0, y, w, h))
            places.append((0, y, w, h))
            y += h
        self.levels = (places + [places[-1]] * MOST_LEVELS)[:MOST_LEVELS]

    def is_for(self, key: tuple[Image, bool, list[float]]) -> bool:
        """Return whether it was made for the same texture, density and mirroring."""
        return self._key[0] is key[0] and self._key[1:] == key[1:]


def _pyramid(texture: Image, density: Floats, *, mirror: bool) -> list[Floats]:
    """Return the levels of the texture, encoded and premultiplied, as `core.overlay.composition.laid` makes them."""
    straight = _straight(texture).astype(np.float64)
    source = np.concatenate([straight[..., :3] * straight[..., 3:], straight[..., 3:]], axis=-1)
    if mirror:
        source = np.concatenate([source, source[:, ::-1]], axis=1)
        source = np.concatenate([source, source[::-1]], axis=0)
    levels = [thinned(source, density / DENSITY)]
    while max(levels[-1].shape[:2]) > 1 and len(levels) < MOST_LEVELS:
        levels.append(halved(levels[-1]))
    return levels


def _density(dressing: Dressing, basis: Floats) -> Floats:
    """Return texture samples per pixel of undeformed cloth, across and down: (2,)."""
    samples = np.diag([dressing.texture.width_px, dressing.texture.height_px])
    density: Floats = np.linalg.norm(samples @ dressing.placement.matrix(basis) @ np.linalg.inv(basis), axis=1)
    return density


def _straight(image: Image) -> Singles:
    """Return encoded colours and alpha, (H, W, 4)."""
    alpha = color.unit(image.pixels[..., -1:]) if image.has_alpha else np.ones((*image.pixels.shape[:2], 1), np.float32)
    return np.concatenate([encoded(image), alpha], axis=-1).astype(np.float32)


def _rgba(values: Pixels) -> Singles:
    """Return (H, W) or (H, W, 3) as (H, W, 4)."""
    colours = values[..., None] if values.ndim == 2 else values
    full = np.ones((*colours.shape[:2], 4), np.float32)
    full[..., :3] = colours
    return full


def _texture(context: moderngl.Context, values: Singles, dtype: str) -> moderngl.Texture:
    texture = context.texture((values.shape[1], values.shape[0]), 4, values.astype(dtype), dtype=dtype)
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return texture
