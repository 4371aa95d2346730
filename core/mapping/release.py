"""The picture's outline, let go of where no mapping without folds has it at W.

Outline nodes outside features are then free, and held by an energy over the outline's edges, in units of a cell,

    λ/2 Σ (|d(z - W)|² + |z - W|² / L²) + τ/2 Σ |z - W|²,

so that they leave W around what does not fit, and come back to it over a length of L cells. The ties τ are those of
nodes that are to be brought to W again.
"""

import numpy as np

from core.arrays import Bools, Floats, Ints
from core.grid import Grid
from core.mapping.assembly import packed
from core.mapping.feature_mapping import FeatureMapping
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
    """The energy of outline edges between nodes (N,) of which one may `move`, where no end is in a feature.

    `outer` are the nodes outside features, `unit` is the area of a cell.
    """

    def __init__(self, grid: Grid, outer: Bools, move: Bools, w: Complexes, unit: float) -> None:
        ring = around(grid)
        edges = np.stack([ring, np.roll(ring, -1)], axis=1)
        self.edges = edges[outer[edges].all(axis=1) & move[edges].any(axis=1)]
        self._wanted, self._side = w.ravel()[self.edges], np.sqrt(unit)
        self._curvature = np.broadcast_to(_CURVATURE, (len(self.edges), 4, 4))

    def tie(self, nodes: Bools, strength: float) -> None:
        """Tie `nodes` (N,) to W with τ = `strength`, the others not at all."""
        ties = np.repeat(np.where(nodes[self.edges], strength / 2, 0.0), 2, axis=1)
        self._curvature = _CURVATURE + ties[:, :, None] * np.eye(4)

    def energy(self, z: Complexes) -> float:
        """Return the energy of nodes at z (N,)."""
        away = self._away(z)
        return float((self._pull(away) * away).sum() / 2)

    def model(self, z: Complexes) -> tuple[Floats, Floats]:
        """Return its gradient (m, 4) and second derivative, packed (m, 10), by the x, y of each edge's ends."""
        return self._pull(self._away(z)) / self._side, packed(self._curvature) / self._side**2

    def _pull(self, away: Floats) -> Floats:
        """Return the energy's slope by `away` (m, 4)."""
        return np.asarray((self._curvature @ away[..., None])[..., 0])

    def _away(self, z: Complexes) -> Floats:
        """Return how far the ends are from W, in cells (m, 4)."""
        return np.asarray((z[self.edges] - self._wanted).view(np.float64) / self._side)


def around(grid: Grid) -> Ints:
    """Return the outline's node numbers, clockwise from the top left."""
    number = np.arange(grid.size).reshape(grid.shape)
    return np.concatenate([number[0], number[1:, -1], number[-1, -2::-1], number[-2:0:-1, 0]])


def crosses_itself(ring: Complexes) -> bool:
    """Return whether the closed line through `ring` (n,) crosses itself."""
    # Two edges cross where the ends of each lie to either side of the other; that takes boxes that meet.
    one, other = _edges_whose_boxes_meet(ring)
    on = _ON * np.abs(ring - ring[0]).max()
    return bool((_are_parted(ring, one, other, on) & _are_parted(ring, other, one, on)).any())


def _edges_whose_boxes_meet(ring: Complexes) -> tuple[Ints, Ints]:
    """Return pairs of edges of the closed line that share no end, each edge by the number of its first point."""
    meet = np.ones((len(ring), len(ring)), bool)
    for start in (ring.real, ring.imag):
        end = np.roll(start, -1)
        meet &= np.minimum(start, end)[:, None] <= np.maximum(start, end)
    one, other = np.nonzero(meet & meet.T)
    chosen = (other > one + 1) & (other - one < len(ring) - 1)
    return one[chosen], other[chosen]


def _are_parted(ring: Complexes, ends: Ints, lines: Ints, on: float) -> Bools:
    """Return whether the line through an edge parts the ends of another, for pairs of them.

    What is nearer than `on` is to neither side of it, whatever the rounding.
    """
    after = np.roll(ring, -1)
    along, near = after[lines] - ring[lines], on * np.abs(after[lines] - ring[lines])
    first, second = ((np.conj(along) * (z[ends] - ring[lines])).imag for z in (ring, after))
    return np.asarray((np.minimum(first, second) < -near) & (np.maximum(first, second) > near))


def outer_nodes(mapping: FeatureMapping) -> Bools:
    """Return the outline nodes (R, C) outside features."""
    return np.asarray(mapping.grid.outline & (mapping.index < 0))
