"""Many lines of places at once, one after another in one array."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from core.arrays import Bools, Floats, Ints, Points


@dataclass(frozen=True, eq=False)
class Polylines:
    """Lines (k) of at least two places each."""

    places: Points
    """(n, 2), those of the first line, then those of the second, and so on."""
    count: Ints
    """(k,) places of each line."""

    @cached_property
    def first(self) -> Ints:
        """Numbers (k,) of the lines' first places."""
        return np.cumsum(self.count) - self.count

    @cached_property
    def line(self) -> Ints:
        """Which line each place (n,) is on."""
        return np.repeat(np.arange(len(self.count)), self.count)

    @cached_property
    def along(self) -> Floats:
        """Arc length (n,) from its line's start to each place."""
        step = np.linalg.norm(np.diff(self.places, axis=0, prepend=self.places[:1]), axis=1)
        step[self.first] = 0
        total = np.cumsum(step)
        return np.asarray(total - total[self.first][self.line])

    @property
    def length(self) -> Floats:
        """Lengths (k,) of the lines."""
        return np.asarray(self.along[self.first + self.count - 1])

    @property
    def tangent(self) -> Points:
        """Unit tangents (n, 2): the way from the place before to the one after it."""
        number = np.arange(len(self.line))
        before = np.maximum(number - 1, self.first[self.line])
        after = np.minimum(number + 1, (self.first + self.count - 1)[self.line])
        way = self.places[after] - self.places[before]
        return np.asarray(way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12))

    def all(self, which: Bools) -> Bools:
        """Return for which lines (k, ...) all their places are among `which` (n, ...)."""
        return np.logical_and.reduceat(which, self.first, axis=0)

    def split(self) -> list[slice]:
        """Return which places each line has."""
        return [slice(start, start + count) for start, count in zip(self.first, self.count, strict=True)]

    def take(self, numbers: Ints) -> "Polylines":
        """Return the lines of some `numbers`, in that order."""
        count = self.count[numbers]
        return Polylines(self.places[np.repeat(self.first[numbers], count) + count_up(count)], count)

    def resample(self, step_px: float) -> "Polylines":
        """Return the lines with places evenly along them, about `step_px` apart."""
        parts = np.maximum(np.rint(self.length / step_px).astype(int), 2)
        line = np.repeat(np.arange(len(parts)), parts + 1)
        share = count_up(parts + 1) / parts[line]
        # One line begins a pixel after the other has ended, so that no place is between two.
        start = np.cumsum(self.length + 1) - self.length
        given, asked = start[self.line] + self.along, start[line] + share * self.length[line]
        places = [np.interp(asked, given, column) for column in self.places.T]
        return Polylines(np.stack(places, axis=-1), parts + 1)


def count_up(counts: Ints) -> Ints:
    """Return 0, 1, ... up to each of the `counts` (k,), one after another."""
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
