"""The result while it grows: colours, where they come from, and the seams between patches.

A patch is merged by one move of a graph cut (Kwatra et al. 2003): every pixel of its window keeps what it shows or
takes the patch, at the least total cost of the seams. With A what is shown and B the patch, the seam between
neighbours p and q costs, when just one of them takes the patch,

    M(p, q) = |A(p) - B(p)|^2 + |A(q) - B(q)|^2 + |(A(q) - A(p)) - (B(q) - B(p))|^2,

its last term the difference of their gradients. Squares, since one break through a stroke shows more than many faint
steps beside it. When both keep, the cost S(p, q) of a seam that already runs between
them stays; when both take, none. That is a cut with the edge weight M - S / 2 and S / 2 at either terminal of keeping.
"""

from typing import TypeAlias

import maxflow
import numpy as np

from core.arrays import Bools, Floats, Ints, Singles

Window: TypeAlias = tuple[slice, slice]
"""Rows and columns."""
NEVER = 1e6
RIGHT = np.array([[0, 0, 0], [0, 0, 1], [0, 0, 0]])
BELOW = np.array([[0, 0, 0], [0, 0, 0], [0, 1, 0]])
CELL = 4
"""Uses of the source are counted in cells of this many pixels a side."""


class Canvas:
    """The result at every pixel of the picture; label 0 is the plain deformation."""

    def __init__(self, colour: Singles, place: Singles, *, must: Bools, may: Bools) -> None:
        self.colour = colour
        """(H, W, c) what is shown now."""
        self.place = place.copy()
        """(H, W, 2) the pixel of the source that is shown."""
        self.label: Ints = np.zeros(may.shape, np.int32)
        self.right = np.zeros(may.shape, np.float32)
        """(H, W) cost of the seam between a pixel and its right neighbour."""
        self.below = np.zeros(may.shape, np.float32)
        self.may = may
        self.bare = must.copy()
        """(H, W) still shows the plain deformation, and must not."""
        self.uses = np.zeros((may.shape[0] // CELL + 1, may.shape[1] // CELL + 1), np.float32)
        """How often each cell of the source is shown, on average over its pixels."""

    def merge(self, window: Window, label: int, colour: Singles, place: Singles, reach: Bools) -> int:
        """Merge a patch where it reaches and return the number of pixels that took it."""
        reach = reach & self.may[window]
        if not reach.any():
            return 0
        seams = _seams(self.colour[window] - colour)
        taken = self._cut(window, seams, np.where(reach, 0, 2 * NEVER)) & reach
        if not taken.any():
            return 0
        self._reseam(window, seams, taken)
        old = self.place[window][taken & (self.label[window] > 0)]
        self._count(old, -1)
        self._count(place[taken], 1)
        self.colour[window][taken] = colour[taken]
        self.place[window][taken] = place[taken]
        self.label[window][taken] = label
        self.bare[window][taken] = False
        return int(taken.sum())

    def _cut(self, window: Window, seams: tuple[Singles, Singles], take: Floats) -> Bools:
        right, below = seams
        old_right, old_below = self.right[window][:, :-1], self.below[window][:-1]
        keep = np.where(self.bare[window], NEVER, 0.0)
        keep[:, :-1] += old_right / 2
        keep[:, 1:] += old_right / 2
        keep[:-1] += old_below / 2
        keep[1:] += old_below / 2
        graph = maxflow.GraphFloat(take.size, 2 * take.size)
        nodes = graph.add_grid_nodes(take.shape)
        across = np.zeros(take.shape)
        across[:, :-1] = np.maximum(right - old_right / 2, 0)
        graph.add_grid_edges(nodes, across, RIGHT, symmetric=True)
        down = np.zeros(take.shape)
        down[:-1] = np.maximum(below - old_below / 2, 0)
        graph.add_grid_edges(nodes, down, BELOW, symmetric=True)
        graph.add_grid_tedges(nodes, keep, take)
        graph.maxflow()
        return np.asarray(~graph.get_grid_segments(nodes))

    def _reseam(self, window: Window, seams: tuple[Singles, Singles], taken: Bools) -> None:
        right, below = seams
        for cost, seam, (a, b) in (
            (right, self.right[window][:, :-1], (taken[:, :-1], taken[:, 1:])),
            (below, self.below[window][:-1], (taken[:-1], taken[1:])),
        ):
            seam[a & b] = 0
            border = a ^ b
            seam[border] = cost[border]

    def _count(self, place: Singles, sign: int) -> None:
        cell = (place / CELL).astype(np.int64)
        np.clip(cell, 0, [self.uses.shape[1] - 1, self.uses.shape[0] - 1], out=cell)
        np.add.at(self.uses, (cell[:, 1], cell[:, 0]), sign / CELL**2)


def _seams(difference: Singles) -> tuple[Singles, Singles]:
    """Return M for right and lower neighbours from A - B (h, w, c)."""
    size = _size(difference)
    right = size[:, :-1] + size[:, 1:] + _size(difference[:, 1:] - difference[:, :-1])
    below = size[:-1] + size[1:] + _size(difference[1:] - difference[:-1])
    return right, below


def _size(difference: Singles) -> Singles:
    """Return the sum of squares over the channels; adding three planes is ten times as fast as a reduction."""
    size = difference[..., 0] ** 2
    for i in range(1, difference.shape[-1]):
        size += difference[..., i] ** 2
    return size
