"""Which nodes of a grid are in which feature of a mask, kept up to date while that is painted."""

import numpy as np

from core.arrays import readonly
from core.grid import Features, Grid
from core.rasters.components import Components
from core.rasters.raster import Raster
from core.selection.features import MARKED, MOST, without_numbered


class MarkedNodes:
    """The features of a mask and its numbers, as they fall on the nodes of one grid.

    A feature is called by its number; those without are called as `cv2.connectedComponents` numbers them, from 256 on
    where there are numbers at all.
    """

    def __init__(self, grid: Grid) -> None:
        self._grid = grid
        self._components = Components(*grid.pixels)
        self._seen: tuple[Raster, Raster | None, frozenset[int]] | None = None
        self._loose: Raster | None = None
        """What of the mask has no number."""
        self._found = Features(readonly(np.zeros(grid.shape, np.int32)))

    def features(self, mask: Raster, numbers: Raster | None, given_up: frozenset[int] = frozenset()) -> Features:
        """Return the features but for those `given_up`, the same object as before while no node's number changed."""
        seen = self._seen
        if seen is None or (mask, numbers, given_up) != seen:
            found = self._labels(mask, numbers)
            found[np.isin(found, list(given_up))] = 0
            if seen is None or not np.array_equal(found, self._found.labels):
                self._found = Features(readonly(found))
            self._seen = mask, numbers, given_up
        return self._found

    def _labels(self, mask: Raster, numbers: Raster | None) -> np.ndarray[tuple[int, ...], np.dtype[np.int32]]:
        """Return the number of every node (R, C), 0 for those in no feature."""
        if numbers is None:
            return self._components.labels(mask)
        loose_now = without_numbered(mask, numbers)
        self._loose = loose_now if self._loose is None else loose_now.sharing(self._loose)
        loose = self._components.labels(self._loose)
        where = np.ix_(*self._grid.pixels)
        own = np.where(mask.array[where] > MARKED, numbers.array[where], 0)
        return np.where(own > 0, own, np.where(loose > 0, loose + MOST, 0)).astype(np.int32)
