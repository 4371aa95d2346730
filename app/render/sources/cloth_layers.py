"""The layers of a decomposed photo at every level of a pyramid, as the textures that cloth.frag reads."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import cv2
import moderngl
import numpy as np
from numpy.typing import NDArray

from app.render.gpu import release
from app.render.sources.overlay_parameters import ClothParts
from app.render.sources.source import Box
from core.arrays import Singles
from core.imaging import color
from core.imaging.images import Image
from core.overlay.composition import finite, light_of, middle_of
from core.overlay.laying.compositing import encode

Halves: TypeAlias = NDArray[np.float16]
ALL = slice(None)
BAND = 128
"""Rows that are worked on together."""
NEAR = 0.5
"""Coordinates of one block of pixels that differ by more texels belong to two pieces of cloth."""


@dataclass(frozen=True, eq=False)
class LayerLevel:
    """All layers at one size, (h, w, 4) each; half precision is enough for all but the coordinates."""

    coordinates: Singles
    """u, v, 1 on cloth, coverage."""
    shading: Halves
    detail: Halves
    photo: Halves
    """Encoded colours and alpha."""

    @property
    def arrays(self) -> tuple[Singles | Halves, ...]:
        """The layers in the order of the texture units."""
        return self.coordinates, self.shading, self.detail, self.photo

    def part(self, rows: slice, columns: slice = ALL) -> "LayerLevel":
        """Return a view of some of it."""
        at = rows, columns
        return LayerLevel(self.coordinates[at], self.shading[at], self.detail[at], self.photo[at])

    def halved(self) -> "LayerLevel":
        """Return the level of half the size: means over the pixels of a block that are cloth."""
        coordinates, *others, photo = (_even(array) for array in self.arrays)
        # Where there is no cloth all values are 0.
        mean = _means(coordinates)
        share = 1 / np.maximum(mean[..., 2:3], 0.25)
        coverage = mean[..., 3].copy()
        mean *= share
        _keep_apart(mean, coordinates)
        mean[..., 2], mean[..., 3] = mean[..., 2] > 0, coverage
        shading, detail = ((share * _means(other)).astype(np.float16) for other in others)
        return LayerLevel(mean, shading, detail, _means(photo).astype(np.float16))


def empty_level(height: int, width: int) -> LayerLevel:
    """Return a level without values."""
    shape = (height, width, 4)
    return LayerLevel(np.empty(shape, np.float32), *(np.empty(shape, np.float16) for _ in range(3)))


def half_of(finer: Callable[[slice], LayerLevel], size_px: tuple[int, int]) -> LayerLevel:
    """Return the level of half the size of one of `size_px`, of which `finer` gives rows."""
    width, height = (-(-side // 2) for side in size_px)
    out = empty_level(height, width)
    for top in range(0, height, BAND):
        made = finer(slice(2 * top, 2 * (top + BAND))).halved()
        for whole, band in zip(out.arrays, made.arrays, strict=True):
            whole[top : top + BAND] = band
    return out


def _even(array: Singles | Halves) -> Singles:
    """Return an array (h, w, C) with an even number of rows and columns; the border repeats."""
    h, w = array.shape[:2]
    whole = np.pad(array, ((0, h % 2), (0, w % 2), (0, 0)), mode="edge") if h % 2 or w % 2 else array
    return whole.astype(np.float32, copy=False)


def _means(array: Singles) -> Singles:
    """Return the mean (h / 2, w / 2, C) of every block of 2 x 2."""
    h, w = array.shape[:2]
    return np.asarray(cv2.resize(array, (w // 2, h // 2), interpolation=cv2.INTER_AREA), np.float32)


def _keep_apart(mean: Singles, coordinates: Singles) -> None:
    """Give blocks in which two pieces of cloth meet the coordinates of one of them."""
    blocks = [coordinates[down::2, across::2] for down in (0, 1) for across in (0, 1)]
    first = blocks[-1][..., :2].copy()
    for block in blocks[-2::-1]:
        np.copyto(first, block[..., :2], where=block[..., 2:3] > 0)
    apart = np.zeros(mean.shape[:2], bool)
    for block in blocks[1:]:
        away = np.abs(block[..., :2] - first)
        apart |= (np.maximum(away[..., 0], away[..., 1]) > NEAR) & (block[..., 2] > 0)
    np.copyto(mean[..., :2], first, where=apart[..., None])


def full_level(parts: ClothParts, photo: Image, rows: slice, columns: slice = ALL) -> LayerLevel:
    """Return some of the layers at the photo's own size."""
    covered = finite(parts.uv[rows, columns])
    light = parts.shading if parts.shading.ndim == 3 else parts.shading[..., None]
    out = empty_level(*covered.shape)
    out.coordinates[..., :2], out.shading[...] = parts.uv[rows, columns], light[rows, columns]
    out.detail[..., :3], out.detail[..., 3] = parts.detail[rows, columns], 0
    for layer in (out.coordinates, out.shading, out.detail):
        np.copyto(layer, 0, where=~covered[..., None])
    out.coordinates[..., 2], out.coordinates[..., 3] = covered, parts.coverage[rows, columns]
    seen = photo.with_pixels(photo.pixels[rows, columns])
    out.photo[..., :3] = encode(seen)
    out.photo[..., 3:] = color.unit(seen.pixels[..., -1:]) if photo.has_alpha else 1.0
    return out


class ClothLayers:
    """Levels made when they are asked for, and the textures of the window that was asked for last."""

    DTYPES = ("f4", "f2", "f2", "f2")

    def __init__(self, context: moderngl.Context, parts: ClothParts, photo: Image) -> None:
        self.middle = middle_of(parts.uv)
        self.usual_light = light_of(parts.shading)
        self._context = context
        self._parts, self._photo = parts, photo
        self._levels: list[LayerLevel] = []
        """From half the photo's size on."""
        self._window: tuple[Box, int] | None = None
        self._textures: list[moderngl.Texture] = []

    def use(self, box: Box, base: int, first_unit: int) -> None:
        """Bind the textures of the source pixels of `box` at a level, cut at the picture's border."""
        if self._window != (box, base):
            self._load(box, base)
            self._window = box, base
        for number, texture in enumerate(self._textures):
            texture.use(first_unit + number)

    def _load(self, box: Box, base: int) -> None:
        self.release()
        left, top, right, bottom = (side >> base for side in box)
        level = self._level(base, slice(top, bottom), slice(left, right))
        for array, dtype in zip(level.arrays, self.DTYPES, strict=True):
            part = np.ascontiguousarray(array, dtype)
            texture = self._context.texture((part.shape[1], part.shape[0]), 4, part, dtype=dtype)
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            self._textures.append(texture)

    def _level(self, base: int, rows: slice, columns: slice) -> LayerLevel:
        """Return some of a level; of the finest one nothing is kept."""
        if base == 0:
            return full_level(self._parts, self._photo, rows, columns)
        if not self._levels:
            full = partial(full_level, self._parts, self._photo)
            self._levels.append(half_of(full, self._photo.size_px))
        while len(self._levels) < base:
            last = self._levels[-1]
            height, width = last.coordinates.shape[:2]
            self._levels.append(half_of(last.part, (width, height)))
        return self._levels[base - 1].part(rows, columns)

    def release(self) -> None:
        """Free the textures."""
        release(*self._textures)
        self._textures, self._window = [], None
