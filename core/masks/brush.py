"""Painting into a mask through a deformed grid, so that a dab is round where the artist sees it.

A pixel p of the mask lies at M(p) on the canvas. A stroke piece from a to b covers it by a profile of the distance
d = |M(p) - [a, b]|: wholly up to hardness x radius, not at all from the radius on, smoothly between. That is what
round stamps set infinitely close along the piece leave when each pixel keeps the most it got.

Where the profile is so wide that it hardly bends from pixel to pixel, it is worked out at every few of them.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Bytes, Points, Singles
from core.linalg.blas import one_thread
from core.mesh import Mesh
from core.rasters.raster import TILE_PX, Box, Raster

FULL, HALF = 255, 127
SHARPEST_PX = 1.0
"""The narrowest edge, in canvas pixels: a hard brush is antialiased."""
STEPS_PX = (8, 4)
EDGE_STEPS = 25.0
"""An edge of so many steps is a third of a level from the straight lines between them."""


@dataclass(frozen=True)
class Tip:
    """Shape of the brush."""

    radius_px: float
    """In canvas pixels."""
    hardness: float
    """Share of the radius that is wholly covered, 0 to 1."""

    @property
    def edge_px(self) -> float:
        """Width of the soft edge."""
        return max(self.radius_px * (1 - self.hardness), SHARPEST_PX)

    @property
    def reach_px(self) -> float:
        """Distance from which on nothing is covered."""
        return self.radius_px * (1 + self.hardness) / 2 + self.edge_px / 2

    @property
    def core_px(self) -> float:
        """Distance up to which all is covered; negative for a brush finer than its edge."""
        return self.reach_px - self.edge_px

    def profile(self, distance_px: Singles) -> Singles:
        """Return 0 to 255 at distances from the stroke."""
        share = (np.float32(self.reach_px) - distance_px) * np.float32(1 / self.edge_px)
        np.clip(share, 0, 1, out=share)
        return np.asarray(share * share * (3 * FULL - 2 * FULL * share))

    def coverage(self, distance_px: Singles) -> Bytes:
        """Return whole numbers from 0 to 255 at distances from the stroke."""
        return np.asarray(np.rint(self.profile(distance_px)), np.uint8)


class Stroke:
    """A stroke in progress over the mask it began on. Where it crosses itself it does not build up."""

    def __init__(self, start: Raster, *, erase: bool = False) -> None:
        self.mask = start
        """The mask with the stroke so far."""
        self._start = start
        self._erase = erase
        self._covered = self._blank = Raster.filled(start.width_px, start.height_px)
        self._end: tuple[Points, Tip] | None = None
        """Where the last piece ended, and with which tip."""

    def extend(self, mesh: Mesh, a: Points, b: Points, tip: Tip) -> None:
        """Draw on from canvas position `a` to `b`, (2,) each, over the picture as `mesh` shows it.

        Where the last piece ended all that lies behind its end is covered by that, as by this piece.
        """
        goes_on = self._end is not None and np.array_equal(a, self._end[0]) and tip == self._end[1]
        self._end = b, tip
        low, high = np.minimum(a, b) - tip.reach_px, np.maximum(a, b) + tip.reach_px
        box = mesh.box_near(low, high)
        if box is None:
            return
        before = self._covered
        step = _step_px(mesh, box, tip)
        piece = _Piece(mesh, a, b, tip, goes_on) if step == 1 else _SoftPiece(mesh, a, b, tip, box, step)
        self._covered = before.edited(box, lambda tile, at: piece.covered(tile, at, box))
        self.mask = self.mask.edited(box, lambda tile, at: self._blended(tile, at, before))

    def number_pixels(self, numbers: Raster | None, number: int) -> Raster:
        """Return numbers of pixels, the size of the mask, with those that the stroke covers by over half numbered."""

        def edit(tile: Bytes, at: Box) -> Bytes:
            cover = self._covered.tile_at(at)
            return tile if cover is self._blank.tile_at(at) else np.where(cover > HALF, number, tile).astype(np.uint8)

        start = self._blank if numbers is None else numbers
        return start.edited((0, 0, start.width_px, start.height_px), edit)

    def _blended(self, tile: Bytes, at: Box, before: Raster) -> Bytes:
        """Return the tile as it was at the start, with what is covered painted or taken away, if not so `before`."""
        cover, start = self._covered.tile_at(at), self._start.tile_at(at)
        if cover is before.tile_at(at):
            return tile
        return np.minimum(start, FULL - cover) if self._erase else np.maximum(start, cover)


@dataclass(frozen=True, eq=False)
class _Piece:
    """A straight piece of a stroke, from `a` to `b` (2,) on the canvas."""

    mesh: Mesh
    a: Points
    b: Points
    tip: Tip
    goes_on: bool
    """Whether all that lies behind `a` is covered already."""

    def covered(self, tile: Bytes, at: Box, box: Box) -> Bytes:
        """Return `tile`, which lies at `at`, with what the piece covers within `box`."""
        part = (max(at[0], box[0]), max(at[1], box[1]), min(at[2], box[2]), min(at[3], box[3]))
        inside = (slice(part[1] - at[1], part[3] - at[1]), slice(part[0] - at[0], part[2] - at[0]))
        if (tile[inside] == FULL).all():
            return tile
        corners = self.mesh.nodes_of_box(part)
        if self._misses(corners):
            return tile
        if _distance(corners.T, self.a, self.b).max() <= self.tip.core_px:
            cover: Bytes = np.full((part[3] - part[1], part[2] - part[0]), FULL, np.uint8)
        else:
            cover = self.tip.coverage(_distance(self.mesh.canvas_of_box(part), self.a, self.b))
        if (cover <= tile[inside]).all():
            return tile
        result = tile.copy()
        result[inside] = np.maximum(tile[inside], cover)
        return result

    def _misses(self, corners: Points) -> bool:
        """Return whether what lies between `corners` (n, 2) is beyond reach, or behind the end of the last piece."""
        low, high = corners.min(axis=0), corners.max(axis=0)
        gap = np.maximum(np.maximum(np.minimum(self.a, self.b) - high, low - np.maximum(self.a, self.b)), 0)
        if np.hypot(*gap) >= self.tip.reach_px:
            return True
        return self.goes_on and bool(((corners - self.a) @ (self.b - self.a)).max() <= 0)


class _SoftPiece:
    """A straight piece of a stroke, whose profile is known at every `step`-th pixel of the tiles under `box`."""

    def __init__(self, mesh: Mesh, a: Points, b: Points, tip: Tip, box: Box, step: int) -> None:
        self._step = step
        self._first = tuple(side // TILE_PX * TILE_PX // step - 1 for side in box[:2])
        ends = (-(-side // TILE_PX) * TILE_PX // step + 1 for side in box[2:])
        x, y = ((np.arange(first, end) + 0.5) * step - 0.5 for first, end in zip(self._first, ends, strict=True))
        with one_thread():
            self._cover = tip.profile(_distance(mesh.canvas_of_crossings(x, y), a, b))

    def covered(self, tile: Bytes, at: Box, box: Box) -> Bytes:
        """Return `tile`, which lies at `at`, with what the piece covers."""
        step = self._step
        left, top = (side // step - 1 - first for side, first in zip(at[:2], self._first, strict=True))
        height, width = tile.shape
        cover = self._cover[top : top + 2 - (-height // step), left : left + 2 - (-width // step)]
        if not cover.any() or (tile == FULL).all():
            return tile
        fine = cv2.resize(cover, None, fx=step, fy=step, interpolation=cv2.INTER_LINEAR)
        pixels = cv2.convertScaleAbs(fine[step : step + height, step : step + width])
        return tile if (pixels <= tile).all() else np.maximum(tile, pixels)


def _step_px(mesh: Mesh, box: Box, tip: Tip) -> int:
    """Return at every how many pixels of the picture the profile of `tip` is to be known."""
    stretch = mesh.most_stretch(box)
    return next((step for step in STEPS_PX if step * stretch * EDGE_STEPS <= tip.edge_px), 1)


def _distance(points: Points | Singles, a: Points, b: Points) -> Singles:
    """Return the distance of `points` (2, ...) from the straight piece a b."""
    x, y = np.float32(a[0]) - points[0].astype(np.float32), np.float32(a[1]) - points[1].astype(np.float32)
    along = (np.asarray(b, float) - a).astype(np.float32)
    length2 = float(along @ along)
    if length2 > 0:
        share = np.clip((x * along[0] + y * along[1]) / np.float32(-length2), 0, 1)
        x, y = x + share * along[0], y + share * along[1]
    distance: Singles = np.sqrt(x * x + y * y)
    return distance
