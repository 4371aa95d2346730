"""What lines may do, like features: turn or not, how long they may be, and how much of their bends is taken away.

One that stays upright has the normal that it has in the picture, and M all that is not constant, so that a tilt counts
as a bend. Of one that is protected by p, the share p of its bends is taken away. One with a least and a most size has a
row more: what is linear along the line, read along it, which is its length; where that is out of bounds it is drawn to
the nearer one. A level or plumb one that may turn has that row read across the direction in which W alone takes it: its
tilt, which counts as a bend, too.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints, Points
from core.mapping.features.limits import Limits
from core.mapping.jacobians import Complexes, as_complex

_LEVEL = np.tan(np.deg2rad(3.5))
"""Of 345 long lines in 37 photographs 183 are within so much of an axis, four times as many a degree as just beyond."""


@dataclass(frozen=True, eq=False)
class LineRows:
    """What the rows of M are: bends of all lines, tilts of level and plumb ones, lengths of those that have bounds."""

    owner: Ints
    """The line of each (k,)."""
    bends: Bools
    """Which (k,) are bends or tilts."""
    bounded: Ints
    """The lines of the others,"""
    least: Floats
    most: Floats
    """and their bounds as these rows read them."""
    share: Floats
    """What part of each row (k,) is taken away."""

    @classmethod
    def of(
        cls, limits: tuple[Limits, ...], places: list[Floats], lengths: Floats, counts: Ints, level: Ints
    ) -> "LineRows":
        """Return those of lines with so many bends and with samples at `places` of each, 0 to 1; some are `level`."""
        bounded = np.array([i for i, limit in enumerate(limits) if limit.least > 0 or limit.most < np.inf], np.int64)
        unit = np.array([lengths[i] * np.linalg.norm(places[i] - places[i].mean()) for i in bounded])
        owner = np.concatenate([np.repeat(np.arange(len(counts)), counts), level, bounded])
        return cls(
            owner,
            np.arange(len(owner)) < len(owner) - len(bounded),
            bounded,
            unit * np.array([limits[i].least for i in bounded]),
            unit * np.array([limits[i].most for i in bounded]),
            np.array([limit.weight for limit in limits])[owner],
        )

    def directions(self, along: Complexes) -> Complexes:
        """Return along what each row is read (k,), for the directions of the lines (n,)."""
        return np.asarray(along[self.owner] * np.where(self.bends, 1j, 1))

    def excess(self, read: Floats) -> Floats:
        """Return by how much the rows that were `read` (k,) are to be less; 0 for lengths within their bounds."""
        wrong, first = read.copy(), len(read) - len(self.bounded)
        wrong[first:] -= np.clip(read[first:], self.least, self.most)
        return np.asarray(self.share * wrong)


def bends_of(one: Floats, place: Floats, limits: Limits) -> Floats:
    """Return M (k, s) of a line with samples at `place` (s, 1): all but `one`, and, where it turns, but `place`."""
    straight = np.hstack([one, place]) if limits.turns else one
    return np.asarray(scipy.linalg.null_space(straight.T).T)


def fixed_directions(ends: Points, limits: tuple[Limits, ...]) -> Complexes:
    """Return the directions (n,) of lines that stay upright, as in the picture; 0 for those that turn."""
    along = as_complex(ends[: len(limits), 1] - ends[: len(limits), 0])
    turns = np.array([limit.turns for limit in limits], bool)
    return np.asarray(np.where(turns, 0, along / np.maximum(np.abs(along), np.finfo(float).tiny)))


def are_level(ends: Points, limits: tuple[Limits, ...]) -> Bools:
    """Return which (n,) of the lines are level or plumb in the picture, and may turn."""
    across = np.abs(ends[: len(limits), 1] - ends[: len(limits), 0])
    level = across.min(axis=1) < _LEVEL * across.max(axis=1)
    return np.asarray(level & np.array([limit.turns for limit in limits], bool))


def along_lines(chords: Complexes, fixed: Complexes) -> Complexes:
    """Return the directions (n,) of lines with these `chords`, but for those that are `fixed`."""
    along = chords / np.maximum(np.abs(chords), np.finfo(float).tiny)
    return np.asarray(np.where(fixed != 0, fixed, along))
