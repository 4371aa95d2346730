"""Patches: grids grown at an origin in the result and at the corresponding one in the source (DPD sec. 3.3).

The source grid is larger than the target's by the search reach on every side. Shifting the smaller grid within it
gives the pool of candidates, each by a slice, in coordinates that run along the curve.
"""

from collections import deque
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from core.arrays import Bools, Ints, Points, Singles
from core.retexture.coordinates import DirectionField, located, trace
from core.retexture.layout import Correspondence, Origins
from core.retexture.region import smoothstep
from core.retexture.sampling import read

BATCH = 128
"""Patches grown at a time."""
AHEAD = 2
"""Batches grown in other threads meanwhile."""
SMOOTH = 0.03
"""Up to this contrast stretching shows less than a seam, from twice as much it shows more."""
KEPT_BYTES = 100e6
"""Patches that stay in memory, at most."""
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

    @property
    def window(self) -> int:
        """Side of a square of pixels that holds the patch in any direction."""
        return int(np.ceil(np.hypot(2 * self.spine + 1, 2 * self.rib + 1))) + 4


@dataclass(frozen=True, eq=False)
class Batch:
    """Patches of n origins."""

    shape: PatchShape
    origins: Origins
    target: Singles
    """(n, K, J, 2) positions in the result of the target grids' nodes, K across, J along the curve."""
    source: Singles
    """(n, K', J', 2) positions in the picture of the source grids' nodes."""
    corners: Ints
    """(n, 2) first pixel (x, y) of each patch's window."""
    at: Singles
    """(n, window, window, 2) where in its target grid each pixel lies, as (j, k); NaN outside the patch."""
    boxes: Ints
    """(n, 4) left, top, right and bottom of what a patch covers of its window, with a pixel around it."""


class Patches:
    """The patches of some origins, in batches that are grown when they are asked for; a few thousand are kept."""

    def __init__(self, origins: Origins, shape: PatchShape, fields: Fields, way: Correspondence) -> None:
        self.origins = origins
        self._shape, self._fields, self._way = shape, fields, way
        self._kept: dict[int, Batch] = {}
        along, across = 2 * (shape.spine + shape.search_along), 2 * (shape.rib + shape.search_across)
        self._room = KEPT_BYTES / (8 * (along * across + shape.window**2 + 4 * shape.spine * shape.rib))

    def __len__(self) -> int:
        return len(self.origins)

    @property
    def kept(self) -> bool:
        """Whether all of them stay in memory."""
        return len(self.origins) <= self._room

    def __iter__(self) -> Iterator[Batch]:
        starts = range(0, len(self.origins), BATCH)
        with ThreadPoolExecutor(AHEAD) as pool:
            growing = deque(pool.submit(self._batch, start) for start in starts[:AHEAD])
            for start in starts[AHEAD:]:
                batch = growing.popleft().result()
                growing.append(pool.submit(self._batch, start))
                yield batch
            for rest in growing:
                yield rest.result()

    def _batch(self, start: int) -> Batch:
        if start not in self._kept:
            batch = grown(self.origins.taken(slice(start, start + BATCH)), self._shape, self._fields, self._way)
            if start + BATCH > self._room:
                return batch
            self._kept[start] = batch
        return self._kept[start]


def grown(origins: Origins, shape: PatchShape, fields: Fields, way: Correspondence) -> Batch:
    """Grow the patches of `origins`."""
    target, source = fields
    here = trace(target, origins.target, origins.heading, spine=shape.spine, rib=shape.rib)
    there = trace(
        source,
        origins.source,
        origins.source_heading,
        spine=shape.spine + shape.search_along,
        rib=shape.rib + shape.search_across,
        turn=origins.source_turn,
    )
    rim = np.flatnonzero(read(way.inner, here[:, :: shape.rib, :: shape.spine]).min(axis=(1, 2)) < 1)
    there[rim] = joined(there[rim], origins.taken(rim), shape, target, way)
    corners = np.rint(origins.target).astype(np.int64) - shape.window // 2
    at = located(here, corners, shape.window)
    # Scale-adaptive patches: the middle half, or third, of the grid (DPD sec. 3.5).
    for i in np.flatnonzero(origins.scale > 1):
        off = np.abs(at[i] - [shape.spine, shape.rib])
        limit = np.array([shape.spine, shape.rib]) / origins.scale[i] + 0.5
        at[i][(off > limit).any(axis=-1)] = np.nan
    return Batch(shape, origins, here, there, corners, at, _boxes(np.isfinite(at[..., 0])))


def _boxes(covered: Bools) -> Ints:
    """Return the boxes (n, 4) around the covered pixels of windows (n, side, side), a pixel larger."""
    side = covered.shape[1]
    across, down = np.asarray(covered.any(axis=1)), np.asarray(covered.any(axis=2))
    first = [line.argmax(axis=1) - 1 for line in (across, down)]
    last = [side - line[:, ::-1].argmax(axis=1) + 1 for line in (across, down)]
    box = np.column_stack([first[0], first[1], last[0], last[1]])
    return np.asarray(np.clip(box, 0, side))


def joined(there: Singles, origins: Origins, shape: PatchShape, target: DirectionField, way: Correspondence) -> Singles:
    """Return source grids that go over into the deformation's where it takes over.

    With q the nodes of the target grid, as large as the source's, and w the share of texture's own scale, a node is
    w there + (1 - w) (q + D(q) + o). In rich texture, which would show it if it were stretched, the offset o brings
    both to the same place at the origin, and the cut hides the seam; elsewhere o is 0, and there is no seam.
    """
    if not len(origins):
        return there
    spine, rib = shape.spine + shape.search_along, shape.rib + shape.search_across
    here = trace(target, origins.target, origins.heading, spine=spine, rib=rib)
    share = read(way.inner, here)[..., None]
    plain = here + read(way.displacement.astype(np.float32), here / np.float32(way.grid.step))
    own = smoothstep((read(way.contrast, origins.target) - SMOOTH) / SMOOTH)[:, None]
    off = own * (origins.source.astype(np.float32) - plain[:, rib, spine])
    return share * there + (1 - share) * (plain + off[:, None, None])


def within(positions: Singles, size: tuple[int, int], allowed: Bools | None) -> Bools:
    """Return which `positions` (..., 2) lie in a picture of `size`, (H, W), and on an `allowed` pixel of it."""
    x, y = positions[..., 0], positions[..., 1]
    inside = (x >= 0) & (y >= 0) & (x <= size[1] - 1) & (y <= size[0] - 1)
    if allowed is not None:
        pixel = np.clip(np.rint(positions), 0, [size[1] - 1, size[0] - 1]).astype(np.int64)
        inside &= allowed[pixel[..., 1], pixel[..., 0]]
    return np.asarray(inside)


def coarse(batch: Batch, best: Singles, place: Singles, label: Ints, first_label: int) -> None:
    """Lay a batch's central candidates over `place` (H, W, 2) and `label` (H, W).

    Each pixel is taken from the patch it is most central to.
    `best` (H, W) holds how central the patch there is so far; infinity at first, -1 where nothing may be laid.
    """
    shape = batch.shape
    height, width = best.shape
    window = shape.window
    y, x = np.mgrid[:window, :window]
    px, py = x + batch.corners[:, 0, None, None], y + batch.corners[:, 1, None, None]
    reached = np.isfinite(batch.at[..., 0]) & (px >= 0) & (py >= 0) & (px < width) & (py < height)
    patch = np.nonzero(reached)[0]
    at, pixel = batch.at[reached], (py * width + px)[reached]
    off = np.abs(at - [shape.spine, shape.rib]) / [shape.spine, shape.rib]
    central = off.max(axis=1).astype(np.float32)
    better = central < best.reshape(-1)[pixel]
    # The least central first, so that the most central stays; whole numbers sort several times as fast.
    rank = np.clip(250 * (1 - central[better]), 0, 250).astype(np.uint8)
    order = np.flatnonzero(better)[np.argsort(rank, kind="stable")]
    pixel, patch, at = pixel[order], patch[order], at[order]
    best.reshape(-1)[pixel] = central[order]
    label.reshape(-1)[pixel] = first_label + patch
    place.reshape(-1, 2)[pixel] = grid_places(batch, patch, at)


def grid_places(batch: Batch, patch: Ints, at: Points) -> Singles:
    """Return the source positions of grid places `at` (m, 2) of patches (m,), for their central candidates."""
    rows, columns = batch.source.shape[1:3]
    shape = batch.shape
    where = (at + [shape.search_along, shape.search_across]).astype(np.float32)
    where[:, 1] = np.clip(where[:, 1], 0, rows - 1.001) + patch * rows
    return read(batch.source.reshape(-1, columns, 2), where)
