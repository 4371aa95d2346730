"""Handles of the interactive mode: pins and inner curves as points that are to go somewhere  [FAT sec. 3]."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from core.arrays import Bools, InputError, Ints, Points, as_points
from core.curves.bezier import Curve
from core.grid import Grid

_SPACING = 1.5
"""Samples of a curve lie so many cells apart: closer ones would say the same twice."""
_SAME_SPOT_PX = 0.1


@dataclass(frozen=True, eq=False)
class Handles:
    """Where points of the picture are to go: the constraints of FAT eq. 8.

    Raises `InputError` when there are not as many targets as places.
    """

    pins_at: Points
    """(k, 2), pixels of the picture."""
    pins_to: Points
    """(k, 2), output pixels."""
    curves: Sequence[tuple[Curve, Curve]] = ()
    """Source and target of each inner curve, with corresponding segments."""

    def __post_init__(self) -> None:
        at, to = as_points(self.pins_at, "pins"), as_points(self.pins_to, "pins")
        if len(at) != len(to):
            raise InputError(f"pins: {len(at)} places, but {len(to)} targets")
        object.__setattr__(self, "pins_at", at)
        object.__setattr__(self, "pins_to", to)
        for number, (source, target) in enumerate(self.curves):
            if source.segments != target.segments:
                raise InputError(
                    f"curves[{number}]: {source.segments} segments at the source, {target.segments} at the target"
                )

    @property
    def any(self) -> bool:
        """Whether there are any."""
        return bool(len(self.pins_at) or self.curves)

    def are_pins(self, at: Points) -> Bools:
        """Return which of the places (n, 2) that `points` gives are pins; the others are samples of curves."""
        pins = set(map(tuple, self.pins_at.tolist()))
        return np.array([tuple(place) in pins for place in at.tolist()], bool)

    def points(self, grid: Grid) -> tuple[Points, Points]:
        """Return places and targets (n, 2) of pins and curve samples, each spot once, in an order of their own.

        Pins on one spot that go different ways go to the middle of their targets.
        """
        spacing = _SPACING * min(grid.cell)
        at, to = [*self.pins_at], [*_agreed(self.pins_at, self.pins_to)]
        for source, target in self.curves:
            count = max(2, round(source.length / spacing) + 1)
            t = source.parameter_at(np.linspace(0, source.length, count))
            at.extend(source.at(t))
            to.extend(target.at(t))
        kept = _apart(np.reshape(at, (-1, 2)), len(self.pins_at), spacing / 2)
        found, targets = np.reshape(at, (-1, 2))[kept], np.reshape(to, (-1, 2))[kept]
        # The answer does not depend on the order in which handles were set.
        order = np.lexsort((*targets.T, *found.T))
        return found[order], targets[order]


def _agreed(at: Points, to: Points) -> Points:
    """Return the targets (k, 2) of pins, those of pins on one spot in the middle of theirs."""
    agreed = to.copy()
    pairs = scipy.spatial.cKDTree(at).query_pairs(_SAME_SPOT_PX) if len(at) else set()
    for i in {i for pair in pairs for i in pair}:
        near = [i, *(j for pair in pairs if i in pair for j in pair if j != i)]
        agreed[i] = at[i] + (to[near] - at[near]).mean(axis=0)
    return agreed


def _apart(at: Points, pins: int, distance: float) -> Ints:
    """Return which points to keep: every spot's first pin, and curve samples that are not too close to one before."""
    keep = np.ones(len(at), bool)
    for i, j in sorted(scipy.spatial.cKDTree(at).query_pairs(distance)) if len(at) else []:
        same = np.hypot(*(at[i] - at[j])) <= _SAME_SPOT_PX
        if keep[i] and (j >= pins or same):
            keep[j] = False
    return np.flatnonzero(keep)
