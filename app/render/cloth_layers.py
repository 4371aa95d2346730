"""The layers of a decomposed photo at every level of a pyramid, as the textures that cloth.frag reads."""

from dataclasses import dataclass
from typing import TypeAlias

import moderngl
import numpy as np
from numpy.typing import NDArray

from app.render.dressing import ClothParts
from app.render.source import Box
from core import color
from core.arrays import Singles
from core.images import Image
from core.overlay.composition import finite, light_of, middle_of
from core.overlay.laying import encoded

Halves: TypeAlias = NDArray[np.float16]
NEAR = 0.5
"""Coordinates of one block of pixels that differ by more texels belong to two pieces of cloth."""


@dataclass(frozen=True, eq=False)
class Level:
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

    def halved(self) -> "Level":
        """Return the level of half the size: means over the pixels of a block that are cloth."""
        covered = _blocks(self.coordinates[..., 2:3])
        total = covered.sum(0)
        share = covered / np.maximum(total, 1)
        places = _blocks(self.coordinates[..., :2])
        mean = (share * places).sum(0)
        first = np.take_along_axis(places, covered.argmax(0)[None], 0)[0]
        apart = (np.abs(places - first) * covered).max((0, -1)) > NEAR
        mean[apart] = first[apart]
        coverage = _blocks(self.coordinates[..., 3:]).mean(0)
        return Level(
            np.concatenate([mean, total > 0, coverage], -1).astype(np.float32),
            (share * _blocks(self.shading)).sum(0).astype(np.float16),
            (share * _blocks(self.detail)).sum(0).astype(np.float16),
            _blocks(self.photo).mean(0).astype(np.float16),
        )


def _blocks(array: Singles | Halves) -> Singles:
    """Return the four pixels of every block of 2 x 2, (4, h, w, C); the border repeats."""
    h, w = array.shape[:2]
    even = np.pad(array, ((0, h % 2), (0, w % 2), (0, 0)), mode="edge")
    return np.stack([even[::2, ::2], even[::2, 1::2], even[1::2, ::2], even[1::2, 1::2]]).astype(np.float32)


def full_level(parts: ClothParts, photo: Image) -> Level:
    """Return the layers at the photo's own size."""
    covered = finite(parts.uv.astype(np.float64))
    light = parts.shading if parts.shading.ndim == 3 else parts.shading[..., None]
    alpha = color.unit(photo.pixels[..., -1:]) if photo.has_alpha else np.ones((*covered.shape, 1))
    blank = np.zeros((*covered.shape, 1))
    coordinates = [np.nan_to_num(parts.uv), covered[..., None], parts.coverage[..., None]]
    return Level(
        _packed(*coordinates),
        _packed(np.broadcast_to(np.nan_to_num(light), (*covered.shape, 3)), blank).astype(np.float16),
        _packed(np.nan_to_num(parts.detail), blank).astype(np.float16),
        _packed(encoded(photo), alpha).astype(np.float16),
    )


def _packed(*parts: object) -> Singles:
    return np.concatenate([np.asarray(part, np.float32) for part in parts], -1)


class ClothLayers:
    """Levels made when they are asked for, and the textures of the window that was asked for last."""

    DTYPES = ("f4", "f2", "f2", "f2")

    def __init__(self, context: moderngl.Context, parts: ClothParts, photo: Image) -> None:
        self.middle = middle_of(parts.uv)
        self.usual_light = light_of(parts.shading)
        self._context = context
        self._levels = [full_level(parts, photo)]
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
        while len(self._levels) <= base:
            self._levels.append(self._levels[-1].halved())
        left, top, right, bottom = (side >> base for side in box)
        for array, dtype in zip(self._levels[base].arrays, self.DTYPES, strict=True):
            part = np.ascontiguousarray(array[top:bottom, left:right].astype(dtype))
            texture = self._context.texture((part.shape[1], part.shape[0]), 4, part, dtype=dtype)
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            self._textures.append(texture)

    def release(self) -> None:
        """Free the textures."""
        for texture in self._textures:
            texture.release()
        self._textures, self._window = [], None
