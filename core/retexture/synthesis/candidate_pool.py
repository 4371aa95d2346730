"""What is known of a batch of patches whatever the canvas shows: found once, in another thread."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, starmap

import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.retexture.prefetch import prefetch
from core.retexture.sampling import read, read_nearest
from core.retexture.synthesis.candidate_choice import weigh_drift
from core.retexture.synthesis.graph_cut import CELL
from core.retexture.synthesis.patches import Covered, PatchBatch, Patches
from core.retexture.synthesis.pixel_adjacency import PixelAdjacency, find_adjacency

AT_ONCE_PX = 16_000
"""Pixels merged at a time: a larger graph no longer fits into the processor's cache."""
EVERY = 2
"""Freedom is looked up at every second node: the smallest patches have three."""


@dataclass(frozen=True, eq=False)
class Bounds:
    """Where patches may be, and where texture may be taken from."""

    may: Bools
    """(H, W) of the result."""
    free: Singles
    """(H, W) of the result, see `region.Region`."""
    usable: Bools | None = None
    """(H, W) of the source; None for everywhere."""
    kept: tuple[Ints, Ints] | None = None
    """(H, W) of the source and of the result: the number from 1 of the curve within two pixels, else 0."""
    drawn: int = 0
    """Of the curves, so many, the first, were drawn: texture beyond another one of them is not used."""

    def usable_at(self, positions: Singles, curve: Ints) -> Bools:
        """Return where texture for patches of a `curve` (n,) may be taken at `positions` (n, ..., 2)."""
        inside = within(positions, self.may.shape)
        if self.usable is None and self.kept is None:
            return inside
        pixel = nearest(positions, self.may.shape)
        if self.usable is not None:
            inside &= self.usable.reshape(-1)[pixel]
        if self.kept is not None:
            inside &= _free_for(curve.reshape(-1, *[1] * (pixel.ndim - 1)), self.kept[0].reshape(-1)[pixel])
        return inside

    def hidden_at(self, grids: Singles, curve: Ints) -> Bools:
        """Return which nodes of source grids (n, K', J', 2) lie beyond another drawn curve than their `curve` (n,)."""
        if self.kept is None:
            return np.zeros(grids.shape[:3], bool)
        there = self.kept[0].reshape(-1)[nearest(grids, self.may.shape)]
        return hide((there > 0) & (there <= self.drawn) & (there != curve[:, None, None] + 1))

    def open_to(self, pixel: Ints, curve: Ints) -> Bools:
        """Return which of the result's pixels (m,) patches of a `curve` (m,) may show."""
        allowed = self.may.reshape(-1)[pixel]
        if self.kept is not None:
            allowed &= _free_for(curve, self.kept[1].reshape(-1)[pixel])
        return np.asarray(allowed)


def _free_for(curve: Ints, kept: Ints) -> Bools:
    """Return where no other curve than `curve` runs within two pixels."""
    return np.asarray((kept == 0) | (kept == curve + 1))


def within(positions: Singles | Points, size: tuple[int, ...]) -> Bools:
    """Return which `positions` (..., 2) lie in a picture of `size`, (H, W)."""
    x, y = positions[..., 0], positions[..., 1]
    return np.asarray((x >= 0) & (y >= 0) & (x <= size[1] - 1) & (y <= size[0] - 1))


def nearest(positions: Singles | Points, size: tuple[int, ...]) -> Ints:
    """Return the numbers of the pixels nearest to `positions` (..., 2) in a flattened picture of `size`, (H, W)."""
    x, y = np.clip(np.rint(positions[..., 0]), 0, size[1] - 1), np.clip(np.rint(positions[..., 1]), 0, size[0] - 1)
    return y.astype(np.int64) * size[1] + x.astype(np.int64)


def hide(walls: Bools) -> Bools:
    """Return which nodes of grids (n, K, J) lie behind `walls`, as seen from the middle: round either corner."""
    if not walls.any():
        return walls
    rows, columns = (_spread_outwards(walls, axis) for axis in (1, 2))
    middle, centre = walls.shape[1] // 2, walls.shape[2] // 2
    return np.asarray((rows | columns[:, middle : middle + 1]) & (columns | rows[:, :, centre : centre + 1]))


def _spread_outwards(walls: Bools, axis: int) -> Bools:
    """Return which nodes of grids (n, K, J) have a wall between them and the middle one along an axis."""
    lines = np.moveaxis(walls, axis, 0)
    middle = len(lines) // 2
    found = np.concatenate(
        [np.logical_or.accumulate(lines[middle::-1])[:0:-1], np.logical_or.accumulate(lines[middle:])]
    )
    return np.moveaxis(found, 0, axis)


@dataclass(frozen=True, eq=False)
class Round:
    """Patches that do not touch each other, and come after all earlier ones that they touch."""

    patches: slice
    """Of a stock."""
    pixels: slice
    """Of those that the stock covers."""
    cover: PixelAdjacency


@dataclass(frozen=True, eq=False)
class Candidates:
    """Patches of n origins with their grids of candidates (n, K', J') and of the result (n, K, J), round by round."""

    batch: PatchBatch
    """With those m pixels alone that the patches may show."""
    rounds: list[Round]
    middle: Singles
    """(m, 2) where the central candidates have the pixels, as (j, k) in the source grids."""
    held: Singles
    """(m, 1) how far other candidates may have them elsewhere, as a share of the patches' own freedom."""
    colours: Singles
    """(n, K', J', c + 1) of the candidates, with the sums of their squares for a last channel."""
    variance: Floats
    """(n,) of these."""
    unusable: Singles
    """(n, K', J') 1 where no texture may be taken from."""
    hidden: Bools
    """(n, K', J') what of that lies beyond another curve."""
    cells: Singles
    """(n, K', J', 2) where the uses of candidates are counted, in cells."""
    needed: Singles
    """(n, K, J) 1 where the patch may be used."""
    drift: Floats
    """(n, 2 search_across + 1, 2 search_along + 1), see `candidate_choice.weigh_drift`."""


def gather_candidates(batch: PatchBatch, picture: Singles, bounds: Bounds) -> Candidates:
    """Return what is known of a batch of patches with the colours of a picture (H, W, c)."""
    size, shape = bounds.may.shape, batch.shape
    batch, ends = in_rounds(batch, bounds)
    origins, covered = batch.origins, batch.covered
    first = np.searchsorted(covered.patch, ends)
    starts = zip(starmap(slice, pairwise(ends)), starmap(slice, pairwise(first)), strict=True)
    middle = np.array([shape.search_along, shape.search_across], np.float32)
    whole = np.maximum(origins.free, 1e-3)
    free = bounds.free.reshape(-1)[covered.pixel] / whole[covered.patch]
    colours, variance = _colours(picture, batch.source)
    hidden = bounds.hidden_at(batch.source, origins.curve)
    return Candidates(
        batch,
        [Round(some, mine, find_adjacency(covered.patch[mine], covered.pixel[mine], size)) for some, mine in starts],
        covered.at + middle,
        np.clip(free, 0, 1).astype(np.float32)[:, None],
        colours,
        variance,
        (hidden | ~bounds.usable_at(batch.source, origins.curve)).astype(np.float32),
        hidden,
        batch.source / np.float32(CELL),
        read_nearest(bounds.may.view(np.uint8), batch.target).astype(np.float32),
        weigh_drift(shape, origins.offset, origins.free, _slope(bounds.free, batch.target, whole)),
    )


def _slope(free: Singles, target: Singles, whole: Floats) -> Floats:
    """Return by how much freedom, as a share of the patches' own, changes from a pixel to the next, at most (n,).

    `free` (H, W) is read at `target` grids (n, K, J, 2), and is `whole` (n,) for the patches themselves.
    """
    shares = np.clip(read(free, target[:, ::EVERY, ::EVERY]) / whole[:, None, None], 0, 1)
    across, along = (np.abs(np.diff(shares, axis=axis)).max(axis=(1, 2)) for axis in (1, 2))
    return np.asarray(np.maximum(across, along) / EVERY)


def in_rounds(batch: PatchBatch, bounds: Bounds) -> tuple[PatchBatch, Ints]:
    """Return those patches of a batch that may show anything, round by round, and where rounds begin and end."""
    origins = batch.origins
    covered = batch.covered.where(bounds.open_to(batch.covered.pixel, origins.curve[batch.covered.patch]))
    found = in_parts(rounds(covered, len(origins), bounds.may.shape), np.bincount(covered.patch))
    order = np.concatenate([*found, np.empty(0, np.int64)])
    ends = np.cumsum([0, *map(len, found)])
    taken = PatchBatch(batch.shape, origins.taken(order), batch.target[order], batch.source[order], covered.of(order))
    return taken, ends


def in_parts(groups: list[Ints], pixels: Ints) -> list[Ints]:
    """Return groups of patches that cover `pixels` (n,) each, the large ones in parts of about `AT_ONCE_PX`."""
    counts = [max(round(int(pixels[group].sum()) / AT_ONCE_PX), 1) for group in groups]
    parts = zip(groups, counts, strict=True)
    return [part for group, count in parts for part in np.array_split(group, min(count, len(group)))]


def _colours(picture: Singles, places: Singles) -> tuple[Singles, Floats]:
    """Return colours of grids (n, K', J', c + 1), see `Stock`, and their variances (n,)."""
    plain = read(picture, places)
    colours = np.empty((*plain.shape[:3], plain.shape[3] + 1), np.float32)
    colours[..., :-1] = plain
    np.einsum("nkjc,nkjc->nkj", plain, plain, out=colours[..., -1])
    flat = colours.reshape(len(colours), colours.shape[1] * colours.shape[2], colours.shape[3])
    mean = np.full((1, flat.shape[1]), 1 / flat.shape[1], np.float32) @ flat
    variance = mean[:, 0, -1] - np.einsum("nic,nic->n", mean[..., :-1], mean[..., :-1])
    return colours, np.maximum(variance, 0).astype(np.float64) + 1e-4


def prefetch_candidates(patches: Patches, picture: Singles, bounds: Bounds) -> Iterator[Candidates]:
    """Return the batches of `patches`, the first of them begun at once."""
    # In one thread: patches are laid beside it, and on two cores a third would be in the way of both.
    return prefetch(lambda part: gather_candidates(patches.batch(part), picture, bounds), patches.parts, threads=1)


def rounds(covered: Covered, count: int, size: tuple[int, ...]) -> list[Ints]:
    """Return `count` patches in groups that do not touch, each after all earlier patches that it touches.

    Laying a group at once comes to the same as laying its patches one by one, but for the count of uses. Patches that
    cover nothing are left out.
    """
    width = size[1] + 2
    pixel = covered.pixel + 2 * (covered.pixel // size[1]) + width + 1
    beside = np.array([[0], [-1], [1], [-width], [width]])
    first = np.searchsorted(covered.patch, np.arange(count + 1))
    latest = np.zeros((size[0] + 2) * width, np.uint8)
    number = np.zeros(count, np.int64)
    for i in range(count):
        mine = pixel[first[i] : first[i + 1]]
        if len(mine):
            number[i] = 1 + latest.take(mine + beside).max()
            latest[mine] = number[i]
    return [np.flatnonzero(number == n) for n in range(1, number.max(initial=0) + 1)]
