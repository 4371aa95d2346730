"""The result while it grows: colours, where they come from, and the seams between patches.

A patch is merged by one move of a graph cut (Kwatra et al. 2003): every pixel that it covers keeps what it shows or
takes the patch, at the least total cost of the seams. With A what is shown and B the patch, the seam between
neighbours p and q costs, when just one of them takes the patch,

    M(p, q) = |A(p) - B(p)|^2 + |A(q) - B(q)|^2 + |(A(q) - A(p)) - (B(q) - B(p))|^2,

its last term the difference of their gradients; where q lies outside of the patch it counts as p does. Squares, since
one break through a stroke shows more than many faint steps beside it. When both keep, the cost S(p, q) of a seam that
already runs between them stays; when both take, none. That is a cut with the edge weight M - S / 2 and S / 2 at either
terminal of keeping. Bare pixels take the patch, and those that may not keep what they show, whatever it costs.

The plain deformation is merged last, over all that is regrown, and there either choice costs besides what its map
stretches (see `stretch`). M - S / 2 counts as 0 where it is less, which makes no cut seem cheaper than it is, nor all
or none dearer: what is shown in the end costs no more than all that was regrown, and no more than the plain
deformation.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.arrays import Bools, Ints, Singles
from core.graphs.minimum_cut import minimum_cut
from core.retexture.sampling import read_nearest
from core.retexture.synthesis.pixel_adjacency import PixelAdjacency

BARE, DEFORMED, GROWN = range(3)
"""What a pixel shows: the plain deformation where it must not, or may; or a patch."""
STEADY = 0.3
"""How much the plain deformation counts where a patch overlaps it, against synthesised texture."""
COUNTS = np.array([0, STEADY, 1], np.float32)
"""How much counts what a pixel shows when patches are compared with it, by what it is."""
CELL = 4
"""Uses of the source are counted in cells of this many pixels a side."""
LEAST = 1e-3
"""Costs are counted in steps of this, about what a difference of colours by a hundredth costs. Less is not seen, and
where many costs are equal the cut is found sooner."""
DECIDED = 1e6
"""What it costs to choose otherwise where there is no choice."""


class GrownPicture:
    """The result at every pixel of the picture; label 0 is the plain deformation."""

    def __init__(self, colour: Singles, place: Singles, *, must: Bools, may: Bools) -> None:
        self.colour = colour
        """(H, W, c) what is shown now."""
        self.place = place
        """(H, W, 2) the pixel of the source that is shown; of both what is far from all that may be regrown is 0."""
        self.label: Ints = np.zeros(may.shape, np.int32)
        self.seams = np.zeros((2, *may.shape), np.float32)
        """(2, H, W) cost of the seam between a pixel and its right neighbour, and its lower one."""
        self.state = np.where(must, np.uint8(BARE), np.uint8(DEFORMED))
        """(H, W) `BARE`, `DEFORMED` or `GROWN`."""
        self.uses = np.zeros((may.shape[0] // CELL + 1, may.shape[1] // CELL + 1), np.float32)
        """How often each cell of the source is shown, on average over its pixels."""

    def weigh_at(self, places: Singles) -> Singles:
        """Return how much what is shown at `places` (..., 2) counts beside patches: nothing outside the picture."""
        return COUNTS[read_nearest(self.state, places)]

    def merge(
        self,
        cover: PixelAdjacency,
        label: Ints,
        colour: Singles,
        place: Singles,
        usable: Bools,
        data: tuple[Singles, Singles] | None = None,
    ) -> int:
        """Merge patches that do not touch and return the number of pixels that took them.

        `label` (m,), `colour` (m, c) and `place` (m, 2) are what the patches show at the pixels that they `cover`;
        `usable` (m,) is where they may be shown, and `data` what it costs besides to keep what is shown, and to take
        them (m,).
        """
        shown = self.colour.reshape(-1, self.colour.shape[2]).take(cover.pixel, axis=0)
        # Plane by plane: neighbours are looked up several times as fast as in pixels of several channels.
        planes = list(np.ascontiguousarray((shown - colour).T))
        size = _sum(plane * plane for plane in planes)
        # |d|^2 + |e|^2 + |d - e|^2 = 2 (|d|^2 + |e|^2 - d e), for the differences of neighbours.
        both = _sum(plane.take(cover.one) * plane.take(cover.other) for plane in planes)
        cost = 2 * (size.take(cover.one) + size.take(cover.other) - both)
        edge_cost = 2 * size.take(cover.edge)
        seams = self.seams.reshape(-1)
        old, edge_old = seams.take(cover.seam), seams.take(cover.edge_seam)
        seen = np.flatnonzero(old)
        half, keep, take = old.take(seen) / 2, np.zeros(len(label)), np.zeros(len(label))
        if data is not None:
            keep += data[0]
            take += data[1]
        for pixel, cheaper in ((cover.one.take(seen), half), (cover.other.take(seen), half), (cover.edge, edge_old)):
            keep += np.bincount(pixel, cheaper, len(label))
        take += np.bincount(cover.edge, edge_cost, len(label))
        keep[usable & (self.state.reshape(-1).take(cover.pixel) == BARE)] = DECIDED
        take[~usable] = DECIDED
        taken = _cut(cover, np.maximum(cost - old / 2, 0), keep, take)
        one, other = taken.take(cover.one), taken.take(cover.other)
        seams[cover.seam] = np.where(one ^ other, cost, np.where(one, 0, old))
        seams[cover.edge_seam] = np.where(taken.take(cover.edge), edge_cost, edge_old)
        which = np.flatnonzero(taken)
        pixel, place, label = cover.pixel.take(which), place.take(which, axis=0), label.take(which)
        replaced = pixel[self.label.reshape(-1).take(pixel) > 0]
        self._count(self.place.reshape(-1, 2).take(replaced, axis=0), -1)
        self._count(place[label > 0], 1)
        self.colour.reshape(-1, self.colour.shape[2])[pixel] = colour.take(which, axis=0)
        self.place.reshape(-1, 2)[pixel] = place
        self.label.reshape(-1)[pixel] = label
        self.state.reshape(-1)[pixel] = np.where(label > 0, np.uint8(GROWN), np.uint8(DEFORMED))
        return len(pixel)

    def _count(self, place: Singles, sign: int) -> None:
        cell = (place * np.float32(1 / CELL)).astype(np.int64)
        number = cell[:, 1] * self.uses.shape[1] + cell[:, 0]
        np.add.at(self.uses.reshape(-1), number, np.float32(sign / CELL**2))


def _cut(cover: PixelAdjacency, seam: Singles, keep: NDArray[Any], take: NDArray[Any]) -> Bools:
    """Return which pixels (m,) take the patch: the cheapest cut.

    `seam` (p,) are costs of the pairs where just one takes it, `keep` and `take` (m,) of either choice.
    """
    costs = (np.rint(np.asarray(cost / LEAST, np.float64)) for cost in (seam, keep, take))
    return ~minimum_cut(cover.one, cover.other, *costs)


def _sum(planes: Iterator[Singles]) -> Singles:
    """Return the sum of at least one plane (m,)."""
    total = next(planes)
    for plane in planes:
        total += plane
    return total
