"""One-channel rasters in copy-on-write tiles.

An edit makes a new `Raster` that shares every tile it did not touch, so an undo snapshot costs pointers and only the
tiles that differ go to the GPU.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import cv2
import numpy as np

from core.arrays import Bytes, InputError, readonly

TILE_PX = 128

Box: TypeAlias = tuple[int, int, int, int]
"""x0, y0, x1, y1 in pixels, the far sides excluded."""


@dataclass(frozen=True, eq=False)
class Raster:
    """A (height, width) uint8 picture in read-only tiles of `TILE_PX` pixels; 0 to 255."""

    width_px: int
    height_px: int
    tiles: tuple[tuple[Bytes, ...], ...]

    @classmethod
    def filled(cls, width_px: int, height_px: int, value: int = 0) -> "Raster":
        """Return a raster of one value; its tiles of one shape are one array."""
        shared: dict[tuple[int, int], Bytes] = {}

        def tile(shape: tuple[int, int]) -> Bytes:
            if shape not in shared:
                shared[shape] = readonly(np.full(shape, value, np.uint8))
            return shared[shape]

        return cls(
            width_px, height_px, _tiled(width_px, height_px, lambda box: tile((box[3] - box[1], box[2] - box[0])))
        )

    @classmethod
    def from_array(cls, values: Bytes) -> "Raster":
        """Return the raster of `values`, (H, W) uint8; its tiles of one value and shape are one array."""
        if values.ndim != 2 or values.dtype != np.uint8:
            raise InputError(f"a mask is (height, width) of 8 bit, not {values.shape} of {values.dtype}")
        height, width = values.shape
        flat: dict[tuple[int, ...], Bytes] = {}

        def tile(box: Box) -> Bytes:
            part = readonly(values[box[1] : box[3], box[0] : box[2]].copy())
            if part.min() != part.max():
                return part
            return flat.setdefault((*part.shape, int(part[0, 0])), part)

        return cls(width, height, _tiled(width, height, tile))

    @property
    def array(self) -> Bytes:
        """The whole as (H, W) uint8, read-only. Put together on each call, since history keeps many rasters."""
        return readonly(self.part((0, 0, self.width_px, self.height_px)))

    def part(self, box: Box) -> Bytes:
        """Return the values in `box` (h, w), which begins and ends where tiles do."""
        rows = self.tiles[box[1] // TILE_PX : -(-box[3] // TILE_PX)]
        columns = slice(box[0] // TILE_PX, -(-box[2] // TILE_PX))
        return np.concatenate([np.concatenate(row[columns], axis=1) for row in rows], axis=0)

    @cached_property
    def is_empty(self) -> bool:
        """Whether every pixel is 0."""
        return not any(tile.any() for tile in self._distinct())

    def holds_only(self, value: int) -> bool:
        """Return whether every pixel has one value."""
        return all((tile == value).all() for tile in self._distinct())

    @property
    def inverted(self) -> "Raster":
        """The raster of 255 minus every value; tiles that were one array stay one."""
        flipped = {id(tile): readonly(255 - tile) for tile in self._distinct()}
        return Raster(
            self.width_px, self.height_px, tuple(tuple(flipped[id(tile)] for tile in row) for row in self.tiles)
        )

    def resized(self, width_px: int, height_px: int, *, blends: bool = True) -> "Raster":
        """Return the raster stretched to another size, itself where it has that size.

        Without `blends` every value of the new one is in the old one, too: for numbers that stand for something.
        """
        if (width_px, height_px) == (self.width_px, self.height_px):
            return self
        how = cv2.INTER_LINEAR if blends else cv2.INTER_NEAREST
        return Raster.from_array(np.asarray(cv2.resize(self.array, (width_px, height_px), interpolation=how), np.uint8))

    def sharing(self, before: "Raster") -> "Raster":
        """Return the raster with the tiles of `before` wherever they say the same, so that only others are new."""
        if (before.width_px, before.height_px) != (self.width_px, self.height_px):
            return self
        rows = tuple(
            tuple(old if np.array_equal(old, new) else new for old, new in zip(*row, strict=True))
            for row in zip(before.tiles, self.tiles, strict=True)
        )
        return Raster(self.width_px, self.height_px, rows)

    def _distinct(self) -> list[Bytes]:
        """Return every array once."""
        return list({id(tile): tile for row in self.tiles for tile in row}.values())

    def edited(self, box: Box, edit: Callable[[Bytes, Box], Bytes]) -> "Raster":
        """Return a raster whose tiles under `box` are `edit(tile, box of the tile)`.

        A tile that is returned as it was is shared. `edit` must not write to the tile that it is given.
        """
        left, top, right, bottom = (
            max(box[0], 0),
            max(box[1], 0),
            min(box[2], self.width_px),
            min(box[3], self.height_px),
        )
        if left >= right or top >= bottom:
            return self
        rows = list(self.tiles)
        for y in range(top // TILE_PX, -(-bottom // TILE_PX)):
            row = list(rows[y])
            for x in range(left // TILE_PX, -(-right // TILE_PX)):
                row[x] = readonly(edit(row[x], self.box_of(x, y)))
            rows[y] = tuple(row)
        return Raster(self.width_px, self.height_px, tuple(rows))

    def box_of(self, x: int, y: int) -> Box:
        """Return the pixels that tile number (x, y) covers."""
        return (
            x * TILE_PX,
            y * TILE_PX,
            min((x + 1) * TILE_PX, self.width_px),
            min((y + 1) * TILE_PX, self.height_px),
        )

    def tile_at(self, box: Box) -> Bytes:
        """Return the tile that covers `box`, as `box_of` gives it."""
        return self.tiles[box[1] // TILE_PX][box[0] // TILE_PX]

    def changed_boxes(self, before: "Raster | None") -> Iterator[tuple[Box, Bytes]]:
        """Yield box and values of every tile that is not `before`'s own; all of them where the sizes differ."""
        same_size = before is not None and (before.width_px, before.height_px) == (self.width_px, self.height_px)
        for y, row in enumerate(self.tiles):
            for x, tile in enumerate(row):
                if before is None or not same_size or before.tiles[y][x] is not tile:
                    yield self.box_of(x, y), tile


def _tiled(width_px: int, height_px: int, tile: Callable[[Box], Bytes]) -> tuple[tuple[Bytes, ...], ...]:
    """Return `tile(box)` for every tile, by rows."""
    return tuple(
        tuple(
            tile((x, y, min(x + TILE_PX, width_px), min(y + TILE_PX, height_px))) for x in range(0, width_px, TILE_PX)
        )
        for y in range(0, height_px, TILE_PX)
    )
