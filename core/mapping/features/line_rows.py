"""What lines may do, like features: turn or not, how long they may be, and how much of their bends is taken away.

One that stays upright has the normal that it has in the picture, and M all that is not constant, so that a tilt counts
as a bend. Of one that is protected by p, the share p of its bends is taken away. One with a least and a most size has a
row more: what is linear along the line, read along it, which is its length; where that is out of bounds it is drawn to
the nearer one.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints, Points
from core.mapping.features.limits import Limits
from core.mapping.jacobians import Complexes, as_complex


@dataclass(frozen=True, eq=False)
class LineRows:
    """What the rows of M are: bends of all lines, then lengths of those that have bounds."""

    owner: Ints
    """The line of each (k,)."""
    bends: Bools
    """Which (k,) are bends."""
    bounded: Ints
    """The lines of the others,"""
    least: Floats
    most: Floats
    """and their bounds as these rows read them."""
    share: Floats
    """What part of each row (k,) is taken away."""

    @classmethod
    def of(cls, limits: tuple[Limits, ...], places: list[Floats], lengths: Floats, counts: Ints) -> "LineRows":
        """Return those of lines with so many bends and with samples at `places` of each, 0 to 1."""
        bounded = np.array([i for i, limit in enumerate(limits) if limit.least > 0 or limit.most < np.inf], np.int64)
        unit = np.array([lengths[i] * np.linalg.norm(places[i] - places[i].mean()) for i in bounded])
        owner = np.concatenate([np.repeat(np.arange(len(counts)), counts), bounded])
        return cls(
            owner,
            np.arange(len(owner)) < counts.sum(),
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
        lengths = read[~self.bends]
        wrong = np.concatenate([read[self.bends], lengths - np.clip(lengths, self.least, self.most)])
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


def along_lines(chords: Complexes, fixed: Complexes) -> Complexes:
    """Return the directions (n,) of lines with these `chords`, but for those that are `fixed`."""
    along = chords / np.maximum(np.abs(chords), np.finfo(float).tiny)
    return np.asarray(np.where(fixed != 0, fixed, along))
