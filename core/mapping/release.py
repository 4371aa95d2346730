"""The picture's outline, let go of where no mapping without folds has it at W.

Outline nodes outside features are then free, and held by an energy over the outline's edges, in units of a cell,

    λ/2 Σ (|d(z - W)|² + |z - W|² / L²),

so that they leave W around what does not fit, and come back to it over a length of L cells.
"""

import numpy as np

from core.arrays import Bools, Floats, Ints
from core.grid import Grid
from core.mapping.assembly import packed
from core.mapping.frames import Complexes

_HOLD = 10.0
"""λ."""
_LENGTH = 30.0
"""L, in cells."""
_ON = 1e-9
"""Distance from a line, over the size of the whole, within which a point lies on it."""
_STRETCH = np.kron(np.array([[1.0, -1.0], [-1.0, 1.0]]), np.eye(2))
# An edge's end has half a tie to W, since two edges meet there.
_CURVATURE = _HOLD * (_STRETCH + np.eye(4) / (2 * _LENGTH**2))


class Leash:
    """The energy of outline edges between nodes (N,) that may `move`; `unit` is the area of a cell."""

    def __init__(self, grid: Grid, move: Bools, w: Complexes, unit: float) -> None:
        ring = around(grid)
        edges = np.stack([ring, np.roll(ring, -1)], axis=1)
        self.edges = edges[move[edges].all(axis=1)]
        self._wanted, self._side = w.ravel()[self.edges], np.sqrt(unit)

    def energy(self, z: Complexes) -> float:
        """Return the energy of nodes at z (N,)."""
        away = self._away(z)
        return float(((away @ _CURVATURE) * away).sum() / 2)

    def model(self, z: Complexes) -> tuple[Floats, Floats]:
        """Return its gradient (m, 4) and second derivative, packed (m, 10), by the x, y of each edge's ends."""
        gradient = self._away(z) @ _CURVATURE / self._side
        return gradient, np.broadcast_to(packed(_CURVATURE[None]) / self._side**2, (len(self.edges), 10))

    def _away(self, z: Complexes) -> Floats:
        """Return how far the ends are from W, in cells (m, 4)."""
        return np.asarray((z[self.edges] - self._wanted).view(np.float64) / self._side)


def around(grid: Grid) -> Ints:
    """Return the outline's node numbers, clockwise from the top left."""
    number = np.arange(grid.size).reshape(grid.shape)
    return np.concatenate([number[0], number[1:, -1], number[-1, -2::-1], number[-2:0:-1, 0]])


def crosses_itself(ring: Complexes) -> bool:
    """Return whether the closed line through `ring` (n,) crosses itself."""
    along = np.roll(ring, -1) - ring
    sides = (np.conj(along)[:, None] * (ring[None] - ring[:, None])).imag
    # What lies on a line is to neither side of it, whatever the rounding.
    sides[np.abs(sides) < _ON * np.abs(along)[:, None] * np.abs(ring - ring[0]).max()] = 0
    apart = sides * np.roll(sides, -1, axis=1) < 0
    meets = apart & apart.T
    n, rows = len(ring), np.arange(len(ring))
    for shift in (-1, 0, 1):
        meets[rows, (rows + shift) % n] = False
    return bool(meets.any())
