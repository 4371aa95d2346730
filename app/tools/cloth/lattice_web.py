"""The lines of a lattice: worked out once for a lattice, however often they are drawn."""

from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from core.arrays import Bools, Ints, Points
from core.document.document import pixels_from_places
from core.document.overlay_settings import LatticeVertices
from core.overlay.detection.lattice import neighbour_rows

FAR = 2.5
"""Steps so many times as long as the usual one lie between two pieces of cloth."""


class Web:
    """What of the vertices at `points` (n, 2), canvas pixels, with whole coordinates `keys` (n, 2), goes together."""

    def __init__(self, keys: Ints, points: Points) -> None:
        self._keys, self.points = keys, points

    @cached_property
    def step(self) -> float:
        """The median length of the lattice's steps; infinite where no vertices lie a step apart."""
        near = self._near[:, :2]
        rows, sides = np.nonzero(near >= 0)
        if not len(rows):
            return np.inf
        return float(np.median(np.hypot(*(self.points[near[rows, sides]] - self.points[rows]).T)))

    @cached_property
    def chains(self) -> list[Ints]:
        """The rows of vertices that follow one another without a gap along either direction of the lattice."""
        found: list[Ints] = []
        for axis in (0, 1):
            order = np.lexsort((self._keys[:, axis], self._keys[:, 1 - axis]))
            step = np.diff(self._keys[order], axis=0)
            length = np.hypot(*np.diff(self.points[order], axis=0).T)
            goes_on = (step[:, 1 - axis] == 0) & (step[:, axis] == 1) & (length <= FAR * self.step)
            found.extend(run for run in np.split(order, np.flatnonzero(~goes_on) + 1) if len(run) > 1)
        return found

    def quads(self, chosen: Bools) -> Ints:
        """Return the rows (m, 4) of the corners of the quads to the right of and below `chosen` vertices."""
        rows = np.flatnonzero(chosen)
        right, below = self._near[rows, 0], self._near[rows, 1]
        across = np.where(right >= 0, self._near[right, 1], -1)
        quads = np.stack([rows, right, across, below], axis=1)[(right >= 0) & (below >= 0) & (across >= 0)]
        return np.asarray(quads[np.ptp(self.points[quads], axis=1).max(axis=1, initial=0) <= FAR * self.step])

    @cached_property
    def _near(self) -> Ints:
        return neighbour_rows(self._keys)


_KNOWN: "WeakKeyDictionary[LatticeVertices, tuple[tuple[int, int], Web]]" = WeakKeyDictionary()


def web_of(lattice: LatticeVertices, size_px: tuple[int, int]) -> Web:
    """Return the web of a lattice on a picture of this size, the same one while the lattice stays."""
    known = _KNOWN.get(lattice)
    if known is None or known[0] != size_px:
        keys = np.rint(lattice.keys).astype(np.int64)
        known = _KNOWN[lattice] = size_px, Web(keys, pixels_from_places(size_px, lattice.places))
    return known[1]
