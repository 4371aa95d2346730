"""Patches: grids grown at an origin in the result and at the corresponding one in the source (DPD sec. 3.3).

The source grid is larger than the target's by the search reach on every side. Shifting the smaller grid within it
gives the pool of candidates, each by a slice, in coordinates that run along the curve.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise, starmap
from typing import TypeAlias

import numpy as np

from core.arrays import Bools, Ints, Singles
from core.retexture.deformation.coordinates import DirectionField, trace_roughly
from core.retexture.deformation.grids import fill, locate
from core.retexture.origins import Origins
from core.retexture.prefetch import prefetch
from core.retexture.region import smoothstep
from core.retexture.sampling import LONGEST, read
from core.retexture.synthesis.placement import Correspondence

BATCH, BATCH_BYTES = 128, 40e6
"""Patches grown at a time, and what a batch of them may take."""
FEWER = 4
"""The first batch is so many times as small as others."""
SMOOTH = 0.03
"""Up to this contrast stretching shows less than a seam, from twice as much it shows more."""
Fields: TypeAlias = tuple[DirectionField, DirectionField]
"""Directions in the result and in the source."""


@dataclass(frozen=True)
class PatchShape:
    """Half sizes in px: grids have 2 n + 1 nodes along a side."""

    spine: int = 18
    """Along the curve."""
    rib: int = 9
    """Across it."""
    search_along: int = 12
    """Candidates lie up to this far from the corresponding place, along the curve."""
    search_across: int = 6
    """And across it."""

    @classmethod
    def for_picture(cls, height: int, width: int) -> "PatchShape":
        """Return patches that grow with the square root of a picture's longer side, up to twice the usual."""
        scale = float(np.clip(np.sqrt(max(height, width) / 1000), 1, 2))
        return cls(*(round(scale * value) for value in (cls.spine, cls.rib, cls.search_along, cls.search_across)))

    def smaller(self, scale: float) -> "PatchShape":
        """Return scale-adaptive patches: the middle half, or third, of these (DPD sec. 3.5), searched for as far."""
        return self if scale == 1 else replace(self, spine=_share(self.spine, scale), rib=_share(self.rib, scale))

    @property
    def window(self) -> int:
        """Side of a square of pixels that holds the patch in any direction."""
        return int(np.ceil(np.hypot(2 * self.spine + 1, 2 * self.rib + 1))) + 4


def _share(half: int, scale: float) -> int:
    return max(int(half / scale + 0.5), 1)


@dataclass(frozen=True, eq=False)
class Covered:
    """The m pixels that n patches cover, patch by patch; those of several count once for each."""

    patch: Ints
    """(m,) which patch covers it, in order."""
    pixel: Ints
    """(m,) number of the pixel in the flattened picture."""
    at: Singles
    """(m, 2) where it lies in the patch's target grid, as (j, k) from the grid's first node."""

    def where(self, which: Bools) -> "Covered":
        """Return the pixels that `which` (m,) marks."""
        if which.all():
            return self
        return Covered(self.patch[which], self.pixel[which], self.at[which])

    def of(self, order: Ints) -> "Covered":
        """Return the pixels of the patches in `order` (k,), which are numbered by their places in it."""
        first, after = np.searchsorted(self.patch, order), np.searchsorted(self.patch, order + 1)
        count = after - first
        start = np.cumsum(count) - count
        these = np.arange(count.sum()) + np.repeat(first - start, count)
        return Covered(np.repeat(np.arange(len(order)), count), self.pixel[these], self.at[these])


@dataclass(frozen=True, eq=False)
class PatchBatch:
    """Patches of n origins."""

    shape: PatchShape
    origins: Origins
    target: Singles
    """(n, K, J, 2) positions in the result of the target grids' nodes, K across, J along the curve."""
    source: Singles
    """(n, K', J', 2) positions in the picture of the source grids' nodes."""
    covered: Covered


@dataclass(frozen=True, eq=False)
class Patches:
    """The patches of some origins, in batches that are grown in other threads shortly before they are asked for."""

    origins: Origins
    """Those of a scale one after another."""
    shape: PatchShape
    fields: Fields
    way: Correspondence

    def __len__(self) -> int:
        return len(self.origins)

    def __iter__(self) -> Iterator[PatchBatch]:
        return prefetch(self.batch, self.parts)

    @property
    def parts(self) -> Iterator[slice]:
        """The patches of each batch, all of one scale; few of them in the first, which is waited for."""
        changes = np.flatnonzero(np.diff(self.origins.scale, prepend=0, append=0)).tolist()
        for start, stop in pairwise(changes):
            size = self._size(start)
            first = size if start else -(-size // FEWER)
            starts = [at for at in (start, *range(start + first, stop, size)) if at < stop]
            yield from starmap(slice, pairwise([*starts, stop]))

    def batch(self, which: slice) -> PatchBatch:
        """Return the batch of some patches."""
        return grow(self.origins.taken(which), self._shape(which.start), self.fields, self.way)

    def _shape(self, number: int) -> PatchShape:
        return self.shape.smaller(float(self.origins.scale[number]))

    def _size(self, number: int) -> int:
        shape = self._shape(number)
        rows = 2 * (shape.rib + shape.search_across) + 1
        nodes = rows * (2 * (shape.spine + shape.search_along) + 1)
        # All source grids of a batch lie below each other in one array to read from.
        return max(min(BATCH, int(BATCH_BYTES / (40 * nodes)), LONGEST // rows), 1)


def grow(origins: Origins, shape: PatchShape, fields: Fields, way: Correspondence) -> PatchBatch:
    """Grow the patches of `origins`."""
    target, source = fields
    rough = trace_roughly(target, origins.target, origins.heading, spine=shape.spine, rib=shape.rib)
    here = fill(rough, spine=shape.spine, rib=shape.rib)
    spine, rib = shape.spine + shape.search_along, shape.rib + shape.search_across
    there = trace_roughly(
        source, origins.source, origins.source_heading, spine=spine, rib=rib, turn=origins.source_turn
    )
    rim = np.flatnonzero(read(way.inner, here[:, :: shape.rib, :: shape.spine]).min(axis=(1, 2)) < 1)
    there[rim] = join(there[rim], origins.taken(rim), shape, target, way)
    there = fill(there, spine=spine, rib=rib)
    return PatchBatch(shape, origins, here, there, find_covered(rough, origins, shape, way.inner.shape))


def find_covered(grids: Singles, origins: Origins, shape: PatchShape, size: tuple[int, ...]) -> Covered:
    """Return the pixels of a picture of `size`, (H, W), that `traced` target grids cover."""
    side, width = shape.window, size[1]
    corners = np.rint(origins.target).astype(np.int64) - side // 2
    patch, pixel, at = locate(grids, corners, side, spine=shape.spine, rib=shape.rib)
    inside = np.ones(len(patch), bool)
    leaving = np.asarray(((corners < 0) | (corners + side > size[::-1])).any(axis=1))
    cut = np.flatnonzero(leaving.take(patch))
    y, x = np.divmod(pixel[cut], side) + corners[patch[cut], ::-1].T
    inside[cut] = (x >= 0) & (y >= 0) & (x < width) & (y < size[0])
    number = (width * np.arange(side)[:, None] + np.arange(side)).ravel()
    first = corners[:, 0] + width * corners[:, 1]
    return Covered(patch, number.take(pixel) + first.take(patch), at).where(inside)


def join(there: Singles, origins: Origins, shape: PatchShape, target: DirectionField, way: Correspondence) -> Singles:
    """Return `traced` source grids that go over into the deformation's where it takes over.

    With q the nodes of the target grid, as large as the source's, and w the share of texture's own scale, a node is
    w there + (1 - w) (q + D(q) + o). In rich texture, which would show it if it were stretched, the offset o brings
    both to the same place at the origin, and fades as the share of the curves' coordinates does; elsewhere it is 0.
    """
    if not len(origins):
        return there
    spine, rib = shape.spine + shape.search_along, shape.rib + shape.search_across
    here = trace_roughly(target, origins.target, origins.heading, spine=spine, rib=rib)
    k, j = here.shape[1] // 2, here.shape[2] // 2
    share = read(way.inner, here)[..., None]
    plain = here + read(way.displacement.astype(np.float32), here / np.float32(way.grid.step))
    own = smoothstep((read(way.contrast, origins.target) - SMOOTH) / SMOOTH)[:, None]
    off = own * (origins.source.astype(np.float32) - plain[:, k, j])
    near = read(way.nearness, here)[..., None]
    fading = np.clip(near / np.maximum(near[:, k, j][:, None, None], 1e-3), 0, 1)
    return np.asarray(share * there + (1 - share) * (plain + fading * off[:, None, None]), np.float32)


def grid_places(batch: PatchBatch, some: Ints, at: Singles) -> Singles:
    """Return the source positions of places `at` (m, 2), as (j, k), in the source grids of patches `some` (m,)."""
    rows, columns = batch.source.shape[1:3]
    where = at.astype(np.float32)
    where[:, 1] = np.clip(where[:, 1], 0, rows - 1.001) + some * rows
    return read(batch.source.reshape(-1, columns, 2), where)


def lay_coarsely(batch: PatchBatch, best: Singles, place: Singles, label: Ints, first_label: int) -> None:
    """Lay a batch's central candidates over `place` (H, W, 2) and `label` (H, W).

    Each pixel is taken from the patch it is most central to.
    `best` (H, W) holds how central the patch there is so far; infinity at first, -1 where nothing may be laid.
    """
    shape, all_of = batch.shape, batch.covered
    off = np.abs(all_of.at - [shape.spine, shape.rib]) / [shape.spine, shape.rib]
    central = off.max(axis=1).astype(np.float32)
    flat = best.reshape(-1)
    np.minimum.at(flat, all_of.pixel, central)
    won = all_of.where(central == flat[all_of.pixel])
    label.reshape(-1)[won.pixel] = first_label + won.patch
    middle = np.array([shape.search_along, shape.search_across])
    place.reshape(-1, 2)[won.pixel] = grid_places(batch, won.patch, won.at + middle)
