"""Handles of the interactive mode: pins, rings on them and inner curves  [FAT sec. 3].

A pin or a point of a curve is to go somewhere. A ring around a pin says how the picture is turned and scaled there,
against what it is without handles: by f = s exp(iφ), a complex number.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy

from core.arrays import Bools, InputError, Ints, Points, as_points
from core.curves.bezier import Curve
from core.grid import Grid
from core.mapping.handles.plate import ROUNDED
from core.mapping.handles.probes import Probes
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.tolerances import SEEN_PX

_SPACING = 1.5
"""Samples of a curve lie so many cells apart: closer ones would say the same twice."""
_RING = ROUNDED / 4
"""Radius of a ring as a share of the picture's diagonal."""


@dataclass(frozen=True, eq=False)
class Handles:
    """Where points of the picture are to go, and by how much it is to turn and grow there: constraints of FAT eq. 8.

    Raises `InputError` when there are not as many targets, or rings, as places.
    """

    pins_at: Points
    """(k, 2), pixels of the picture."""
    pins_to: Points
    """(k, 2), output pixels."""
    curves: Sequence[tuple[Curve, Curve]] = ()
    """Source and target of each inner curve, with corresponding segments."""
    rings: Complexes | None = None
    """f of each pin (k,), NaN where it has no ring; None where none has."""

    def __post_init__(self) -> None:
        at, to = as_points(self.pins_at, "pins"), as_points(self.pins_to, "pins")
        if len(at) != len(to):
            raise InputError(f"pins: {len(at)} places, but {len(to)} targets")
        object.__setattr__(self, "pins_at", at)
        object.__setattr__(self, "pins_to", to)
        if self.rings is not None and (len(self.rings) != len(at) or not np.abs(self._f).min(initial=1) > 0):
            raise InputError(f"pins: {len(at)} places, but {len(self.rings)} rings, or one that scales to nothing")
        for number, (source, target) in enumerate(self.curves):
            if source.segments != target.segments:
                raise InputError(
                    f"curves[{number}]: {source.segments} segments at the source, {target.segments} at the target"
                )

    @property
    def any(self) -> bool:
        """Whether there are any."""
        return bool(len(self.pins_at) or self.curves)

    @property
    def _ringed(self) -> Ints:
        """Numbers of the pins that have a ring."""
        return np.flatnonzero(np.isfinite(self.rings)) if self.rings is not None else np.empty(0, np.int64)

    @property
    def _f(self) -> Complexes:
        """What their rings ask for."""
        rings = np.empty(0) if self.rings is None else self.rings
        return np.asarray(rings[self._ringed], np.complex128)

    def are_pins(self, at: Points) -> Bools:
        """Return which of the places (n, 2) that `probes` gives are pins; the others are samples of curves."""
        pins = set(map(tuple, self.pins_at.tolist()))
        return np.array([tuple(place) in pins for place in at.tolist()], bool)

    def probes(self, grid: Grid) -> tuple[Probes, Complexes]:
        """Return pins, rings and samples of curves, each spot once, in an order of their own, and what each asks for.

        Of points that is where they are to be, x + iy; of rings f. Pins on one spot that go different ways go to the
        middle of their targets.
        """
        at, to = self._points(grid)
        ringed = self.pins_at[self._ringed]
        same = np.hypot(*(ringed[:, None] - ringed).T) <= SEEN_PX
        first = np.flatnonzero(same.argmax(axis=0) == np.arange(len(same))) if len(same) else self._ringed
        f = (same[first] @ self._f) / same[first].sum(axis=1)
        radius = ring_radius(grid) * np.append(np.zeros(len(at)), np.ones(len(f)))
        at, asked = np.concatenate([at, ringed[first]]), np.concatenate([as_complex(to), f])
        # The answer does not depend on the order in which handles were set.
        order = np.lexsort((asked.real, asked.imag, *at.T, radius))
        return Probes(at[order], radius[order]), asked[order]

    def _points(self, grid: Grid) -> tuple[Points, Points]:
        """Return places and targets (n, 2) of pins and curve samples, each spot once."""
        on_curves, to_curves = self.sample_curves(grid)
        at = np.concatenate([self.pins_at, on_curves])
        to = np.concatenate([_agree(self.pins_at, self.pins_to), to_curves])
        kept = _apart(at, len(self.pins_at), _SPACING * min(grid.cell) / 2)
        return at[kept], to[kept]

    def sample_curves(self, grid: Grid) -> tuple[Points, Points]:
        """Return points of the inner curves (n, 2), and where they are to be."""
        at, to = [np.empty((0, 2))], [np.empty((0, 2))]
        for source, target in self.curves:
            count = max(2, round(source.length / (_SPACING * min(grid.cell))) + 1)
            t = source.parameter_at(np.linspace(0, source.length, count))
            at.append(source.at(t))
            to.append(target.at(t))
        return np.concatenate(at), np.concatenate(to)


def ring_radius(grid: Grid) -> float:
    """Return the radius of rings in pixels of the picture: no less than a cell."""
    return max(_RING * float(np.hypot(grid.width_px, grid.height_px)), *grid.cell)


def _agree(at: Points, to: Points) -> Points:
    """Return the targets (k, 2) of pins, those of pins on one spot in the middle of theirs."""
    agreed = to.copy()
    pairs = _pairs_within(at.tobytes(), SEEN_PX)
    for i in {i for pair in pairs for i in pair}:
        near = [i, *(j for pair in pairs if i in pair for j in pair if j != i)]
        agreed[i] = at[i] + (to[near] - at[near]).mean(axis=0)
    return agreed


@lru_cache(maxsize=8)
def _pairs_within(at: bytes, distance: float) -> tuple[tuple[int, int], ...]:
    """Return which of some points (n, 2), as bytes, are near one another, ascending: the same while only goals move."""
    points = np.frombuffer(at).reshape(-1, 2)
    return tuple(sorted(scipy.spatial.cKDTree(points).query_pairs(distance))) if len(points) else ()


def _apart(at: Points, pins: int, distance: float) -> Ints:
    """Return which points to keep: every spot's first pin, and curve samples that are not too close to one before."""
    keep = np.ones(len(at), bool)
    for i, j in _pairs_within(at.tobytes(), distance):
        same = np.hypot(*(at[i] - at[j])) <= SEEN_PX
        if keep[i] and (j >= pins or same):
            keep[j] = False
    return np.flatnonzero(keep)
