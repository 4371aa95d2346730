"""The layers of a decomposed photo at a larger size, so that a texture is sampled at the size of the export.

A place between pixels is told by each of the four around it, by its coordinates and their slope there; those that
differ from the nearest one's by a jump belong to another piece of cloth and have no say.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from core.arrays import Bools, Floats, Ints, Singles
from core.imaging.image import Image
from core.overlay.composition import Norm, finite
from core.overlay.filters.texture_filter import steepness
from core.overlay.laying.compositing import Parts

JUMP = 0.25
"""Texels between what two neighbours tell of a place from which they are of two pieces."""
LEAST = 1e-9
Corners: TypeAlias = list[tuple[Ints, Ints]]
"""Rows (h,) and columns (w,) of pixels, of which every row meets every column."""


@dataclass(frozen=True)
class EnlargedParts:
    """Parts whose photo is shown at another size: `source` is that picture, the rest is interpolated."""

    parts: Parts
    source: Image

    @cached_property
    def norm(self) -> Norm:
        """That of the parts, with as many more pixels a texel."""
        norm = self.parts.norm
        factors = np.divide(self.source.size_px, self.parts.uv.shape[1::-1])
        return Norm(factors[:, None] * norm.scale, norm.middle, norm.light)

    @cached_property
    def _slopes(self) -> tuple[Floats, Floats]:
        """Changes of uv (H, W, 2) from row to row and from column to column."""
        return steepness(self.parts.uv.astype(np.float64), 0), steepness(self.parts.uv.astype(np.float64), 1)

    def rows(self, first: int, last: int) -> tuple[Floats, Floats, Floats, Floats]:
        """Return uv, shading and detail, NaN outside the cloth, and coverage of the rows from `first` up to `last`."""
        parts, (height, width) = self.parts, self.source.pixels.shape[:2]
        y = places(np.arange(first, last), height, parts.uv.shape[0])
        x = places(np.arange(width), width, parts.uv.shape[1])
        corners, plain, weights, uv = self._told(y, x)
        shading, detail = (mixed(layer, corners, weights) for layer in (parts.shading, parts.detail))
        outside = ~finite(uv)
        shading[outside], detail[outside] = np.nan, np.nan
        return uv, shading, detail, mixed(parts.coverage, corners, plain)

    def _told(self, y: Floats, x: Floats) -> tuple[Corners, list[Floats], list[Floats], Floats]:
        """Return the four pixels around places, their bilinear weights (h, w), those in one piece, and uv (h, w, 2)."""
        shape = self.parts.uv.shape[:2]
        (top, down), (left, across) = (split(at, count) for at, count in zip((y, x), shape, strict=True))
        near = np.rint(y).astype(int).clip(0, shape[0] - 1), np.rint(x).astype(int).clip(0, shape[1] - 1)
        middle = self._carried(near, y, x)
        corners, plain, weights, told = [], [], [], []
        for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
            corner = np.minimum(top + i, shape[0] - 1), np.minimum(left + j, shape[1] - 1)
            uv = self._carried(corner, y, x)
            share = np.abs(1 - i - down)[:, None] * np.abs(1 - j - across)
            corners.append(corner)
            plain.append(share)
            weights.append(np.where(self._agree(uv, middle), share, 0.0))
            told.append(np.nan_to_num(uv))
        total = np.maximum(np.sum(weights, axis=0), LEAST)
        weights = [weight / total for weight in weights]
        whole = np.sum([weight[..., None] * uv for weight, uv in zip(weights, told, strict=True)], axis=0)
        return corners, plain, weights, np.where(finite(middle)[..., None], whole, np.nan)

    def _carried(self, pixel: tuple[Ints, Ints], y: Floats, x: Floats) -> Floats:
        """Return uv (h, w, 2) at places as pixels tell it, rows by columns."""
        at = pixel[0][:, None], pixel[1]
        down, across = (slope[at] for slope in self._slopes)
        away = (y - pixel[0])[:, None, None], (x - pixel[1])[:, None]
        return np.asarray(self.parts.uv[at] + down * away[0] + across * away[1], np.float64)

    def _agree(self, uv: Floats, other: Floats) -> Bools:
        """Return where (h, w) two tellings of uv (h, w, 2) are of one piece of cloth."""
        return np.asarray(np.abs(np.nan_to_num(uv - other, nan=np.inf)).max(-1) < JUMP, np.bool_)


def mixed(layer: Singles, corners: Corners, weights: list[Floats]) -> Floats:
    """Return a layer (H, W) or (H, W, C), NaN taken for 0, at places (h, w), of pixels around them under weights."""
    out = np.zeros((*weights[0].shape, *layer.shape[2:]))
    for (rows, columns), weight in zip(corners, weights, strict=True):
        values = np.nan_to_num(layer[rows[:, None], columns].astype(np.float64))
        out += values * weight.reshape(*weight.shape, *(1,) * (layer.ndim - 2))
    return out


def places(at: Ints, count: int, before: int) -> Floats:
    """Return where pixels of a side of `count` lie among the `before` pixels that the side had."""
    return np.asarray((at + 0.5) * before / count - 0.5, np.float64)


def split(at: Floats, count: int) -> tuple[Ints, Floats]:
    """Return the pixel before each place, and how far past it the place is, 0 to 1."""
    first = np.clip(np.floor(at).astype(int), 0, max(count - 2, 0))
    return first, np.clip(at - first, 0, 1)
