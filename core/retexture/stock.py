"""What is known of a batch of patches whatever the canvas shows: found once, in another thread."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.retexture.ahead import ahead
from core.retexture.candidates import drift
from core.retexture.canvas import CELL
from core.retexture.patches import Batch, Covered, Patches
from core.retexture.sampling import read


@dataclass(frozen=True, eq=False)
class Bounds:
    """Where patches may be, and where texture may be taken from."""

    may: Bools
    """(H, W) of the result."""
    usable: Bools | None = None
    """(H, W) of the source; None for everywhere."""
    kept: tuple[Ints, Ints] | None = None
    """(H, W) of the source and of the result: the number of the curve within two pixels, else -1."""

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

    def open_to(self, pixel: Ints, curve: Ints) -> Bools:
        """Return which of the result's pixels (m,) patches of a `curve` (m,) may show."""
        allowed = self.may.reshape(-1)[pixel]
        if self.kept is not None:
            allowed &= _free_for(curve, self.kept[1].reshape(-1)[pixel])
        return np.asarray(allowed)


def _free_for(curve: Ints, kept: Ints) -> Bools:
    """Return where no other curve than `curve` runs within two pixels."""
    return np.asarray((kept < 0) | (kept == curve))


def within(positions: Singles | Points, size: tuple[int, ...]) -> Bools:
    """Return which `positions` (..., 2) lie in a picture of `size`, (H, W)."""
    x, y = positions[..., 0], positions[..., 1]
    return np.asarray((x >= 0) & (y >= 0) & (x <= size[1] - 1) & (y <= size[0] - 1))


def nearest(positions: Singles | Points, size: tuple[int, ...]) -> Ints:
    """Return the numbers of the pixels nearest to `positions` (..., 2) in a flattened picture of `size`, (H, W)."""
    x, y = np.clip(np.rint(positions[..., 0]), 0, size[1] - 1), np.clip(np.rint(positions[..., 1]), 0, size[0] - 1)
    return y.astype(np.int64) * size[1] + x.astype(np.int64)


@dataclass(frozen=True, eq=False)
class Stock:
    """Patches of n origins with their grids of candidates (n, K', J') and of the result (n, K, J)."""

    batch: Batch
    covered: Covered
    """Those pixels that the patches may show."""
    rounds: list[Ints]
    """Patches that do not touch each other, and come after all earlier ones that they touch."""
    colours: Singles
    """(n, K', J', c) of the candidates."""
    squares: Singles
    """(n, K', J') of these, summed over the channels."""
    variance: Floats
    """(n,) of these."""
    unusable: Singles
    """(n, K', J') 1 where no texture may be taken from."""
    cell: Ints
    """(n, K', J') number of the cell in which the uses of a candidate are counted."""
    pixel: Ints
    """(n, K, J) number of the result's pixel at a node."""
    inside: Bools
    """(n, K, J) whether a node lies in the picture."""
    needed: Singles
    """(n, K, J) 1 where the patch may be used."""
    drift: Floats
    """(n, 2 search_across + 1, 2 search_along + 1), see `candidates.drift`."""

    def pixels_of(self, some: Ints) -> tuple[Covered, Ints]:
        """Return what patches `some` (k,) cover, numbered from 0 to k - 1, and the patches' own numbers (m,)."""
        first, after = np.searchsorted(self.covered.patch, some), np.searchsorted(self.covered.patch, some + 1)
        these = np.concatenate([np.arange(a, b) for a, b in zip(first, after, strict=True)])
        number = np.repeat(np.arange(len(some)), after - first)
        return Covered(number, self.covered.pixel[these], self.covered.at[these]), self.covered.patch[these]


def stocked(batch: Batch, picture: Singles, bounds: Bounds) -> Stock:
    """Return what is known of a batch of patches with the colours of a picture (H, W, c)."""
    size, origins = bounds.may.shape, batch.origins
    colours = read(picture, batch.source)
    squares = np.einsum("nkjc,nkjc->nkj", colours, colours)
    flat = colours.reshape(len(colours), -1, colours.shape[3])
    mean = np.full((1, flat.shape[1]), 1 / flat.shape[1], np.float32) @ flat
    variance = squares.mean(axis=(1, 2)) - np.einsum("nic,nic->n", mean, mean) + 1e-4
    pixel, inside = nearest(batch.target, size), within(batch.target, size)
    covered = batch.covered.where(bounds.open_to(batch.covered.pixel, origins.curve[batch.covered.patch]))
    cells = size[0] // CELL + 1, size[1] // CELL + 1
    return Stock(
        batch,
        covered,
        rounds(covered, len(origins), size),
        colours,
        squares,
        variance,
        (~bounds.usable_at(batch.source, origins.curve)).astype(np.float32),
        nearest(batch.source / CELL, cells),
        pixel,
        inside,
        (inside & bounds.may.reshape(-1)[pixel]).astype(np.float32),
        drift(batch.shape, origins.offset, origins.free),
    )


def stocked_ahead(patches: Patches, picture: Singles, bounds: Bounds) -> Iterator[Stock]:
    """Return the batches of `patches`, the first of them begun at once, see `stocked`."""
    return ahead(lambda start: stocked(patches.batch(start), picture, bounds), patches.starts)


def rounds(covered: Covered, count: int, size: tuple[int, ...]) -> list[Ints]:
    """Return `count` patches in groups that do not touch, each after all earlier patches that it touches.

    Laying a group at once comes to the same as laying its patches one by one, but for the count of uses. Patches that
    cover nothing are left out.
    """
    width = size[1] + 2
    pixel = covered.pixel + 2 * (covered.pixel // size[1]) + width + 1
    first = np.searchsorted(covered.patch, np.arange(count + 1))
    latest = np.zeros((size[0] + 2) * width, np.int32)
    number = np.zeros(count, np.int64)
    for i in range(count):
        mine = pixel[first[i] : first[i + 1]]
        if len(mine):
            number[i] = 1 + max(latest[mine + step].max() for step in (0, -1, 1, -width, width))
            latest[mine] = number[i]
    return [np.flatnonzero(number == n) for n in range(1, number.max(initial=0) + 1)]
