"""The result while it grows: colours, where they come from, and the seams between patches.

A patch is merged by one move of a graph cut (Kwatra et al. 2003): every pixel that it covers keeps what it shows or
takes the patch, at the least total cost of the seams. With A what is shown and B the patch, the seam between
neighbours p and q costs, when just one of them takes the patch,

    M(p, q) = |A(p) - B(p)|^2 + |A(q) - B(q)|^2 + |(A(q) - A(p)) - (B(q) - B(p))|^2,

its last term the difference of their gradients; where q lies outside of the patch it counts as p does. Squares, since
one break through a stroke shows more than many faint steps beside it. When both keep, the cost S(p, q) of a seam that
already runs between them stays; when both take, none. That is a cut with the edge weight M - S / 2 and S / 2 at either
terminal of keeping. Nodes of the graph are those pixels alone that have a choice: bare ones take the patch.
"""

from dataclasses import dataclass

import maxflow
import numpy as np

from core.arrays import Bools, Ints, Singles

CELL = 4
"""Uses of the source are counted in cells of this many pixels a side."""


@dataclass(frozen=True, eq=False)
class Pairs:
    """n pairs of neighbouring pixels of which a patch covers at least one."""

    one: Ints
    other: Ints
    """(n,) their numbers among the m pixels that are covered; m stands for all others."""
    seam: Ints
    """(n,) in which element of `Canvas.seams`, flattened, the cost of a seam between them is kept."""
    cost: Singles
    """(n,) of a seam if one of them takes the patch: M."""


class Canvas:
    """The result at every pixel of the picture; label 0 is the plain deformation."""

    def __init__(self, colour: Singles, place: Singles, *, must: Bools, may: Bools) -> None:
        self.colour = colour
        """(H, W, c) what is shown now."""
        self.place = place.copy()
        """(H, W, 2) the pixel of the source that is shown."""
        self.label: Ints = np.zeros(may.shape, np.int32)
        self.seams = np.zeros((2, *may.shape), np.float32)
        """(2, H, W) cost of the seam between a pixel and its right neighbour, and its lower one."""
        self.bare = must.copy()
        """(H, W) still shows the plain deformation, and must not."""
        self.uses = np.zeros((may.shape[0] // CELL + 1, may.shape[1] // CELL + 1), np.float32)
        """How often each cell of the source is shown, on average over its pixels."""
        self._number = np.full((may.shape[0] + 2) * (may.shape[1] + 2), -1, np.int32)
        """Of the picture's pixels with a frame around them: the numbers of those that are being merged."""

    def merge(self, pixel: Ints, label: Ints, colour: Singles, place: Singles) -> int:
        """Merge patches that do not touch and return the number of pixels that took them.

        `pixel` (m,) are numbers of pixels in the flattened picture; `label` (m,), `colour` (m, c) and `place` (m, 2)
        what the patches show there.
        """
        pairs = self._pairs(pixel, self.colour.reshape(-1, self.colour.shape[2]).take(pixel, axis=0) - colour)
        taken = self._cut(pairs, self.bare.reshape(-1)[pixel])
        one, other = taken.take(pairs.one), taken.take(pairs.other)
        flat = self.seams.reshape(-1)
        flat[pairs.seam[one & other]] = 0
        border = one ^ other
        flat[pairs.seam[border]] = pairs.cost[border]
        which = np.flatnonzero(taken[:-1])
        pixel, place = pixel.take(which), place.take(which, axis=0)
        replaced = pixel[self.label.reshape(-1).take(pixel) > 0]
        self._count(self.place.reshape(-1, 2).take(replaced, axis=0), -1)
        self._count(place, 1)
        self.colour.reshape(-1, self.colour.shape[2])[pixel] = colour.take(which, axis=0)
        self.place.reshape(-1, 2)[pixel] = place
        self.label.reshape(-1)[pixel] = label.take(which)
        self.bare.reshape(-1)[pixel] = False
        return len(pixel)

    def _pairs(self, pixel: Ints, difference: Singles) -> Pairs:
        """Return the pairs of the pixels (m,) where patches differ by A - B (m, c) from what is shown."""
        height, width = self.label.shape
        y, x = np.divmod(pixel, width)
        framed, count = (y + 1) * (width + 2) + x + 1, len(pixel)
        self._number[framed] = np.arange(count)
        size = _size(difference)
        parts = []
        for down, right in ((0, 1), (1, 0)):
            step, plane = right + down * (width + 2), down * height * width
            after, before = self._number.take(framed + step), self._number.take(framed - step)
            both = np.flatnonzero(after >= 0)
            beside = after.take(both)
            cost = size.take(both) + size.take(beside)
            cost += _size(difference.take(beside, axis=0) - difference.take(both, axis=0))
            parts.append((both, beside, plane + pixel.take(both), cost))
            last = np.flatnonzero((after < 0) & ((y < height - 1) if down else (x < width - 1)))
            first = np.flatnonzero((before < 0) & ((y > 0) if down else (x > 0)))
            for edge, seam in ((last, pixel[last]), (first, pixel[first] - right - down * width)):
                parts.append((edge, np.full(len(edge), count), plane + seam, 2 * size[edge]))
        self._number[framed] = -1
        return Pairs(*(np.concatenate(part) for part in zip(*parts, strict=True)))

    def _cut(self, pairs: Pairs, bare: Bools) -> Bools:
        """Return which of the pixels (m,) take the patch, and False for all others (m + 1,)."""
        taken = np.append(bare, False)
        free = np.flatnonzero(~bare)
        if not len(free):
            return taken
        node = np.full(len(taken), -1)
        node[free] = np.arange(len(free))
        keep, take = np.zeros(len(free)), np.zeros(len(free))
        old = self.seams.reshape(-1).take(pairs.seam).astype(np.float64)
        one, other = node.take(pairs.one), node.take(pairs.other)
        choice = np.flatnonzero((one >= 0) & (other >= 0))
        i, j, half = one.take(choice), other.take(choice), old.take(choice) / 2
        keep += np.bincount(i, half, len(free)) + np.bincount(j, half, len(free))
        for mine, fixed, its in ((one, pairs.other, other), (other, pairs.one, one)):
            held = np.flatnonzero((mine >= 0) & (its < 0))
            which, takes, cost = mine.take(held), taken.take(fixed.take(held)), pairs.cost.take(held)
            keep += np.bincount(which, np.where(takes, cost, old.take(held)), len(free))
            take += np.bincount(which, np.where(takes, 0, cost), len(free))
        graph = maxflow.GraphFloat(len(free), len(i))
        nodes = graph.add_nodes(len(free))
        weight = np.maximum(pairs.cost.take(choice) - half, 0)
        graph.add_edges(i, j, weight, weight)
        graph.add_grid_tedges(nodes, keep, take)
        graph.maxflow()
        taken[free] = ~graph.get_grid_segments(nodes)
        return taken

    def _count(self, place: Singles, sign: int) -> None:
        limit = self.uses.shape[1] - 1, self.uses.shape[0] - 1
        x, y = (np.clip((place[:, i] / CELL).astype(np.int64), 0, limit[i]) for i in (0, 1))
        np.add.at(self.uses.reshape(-1), y * self.uses.shape[1] + x, np.float32(sign / CELL**2))


def _size(difference: Singles) -> Singles:
    """Return the sums of squares (m,) over the channels; adding planes is ten times as fast as a reduction."""
    size = difference[:, 0] ** 2
    for i in range(1, difference.shape[1]):
        size += difference[:, i] ** 2
    return size
