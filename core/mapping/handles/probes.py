"""What handles read of a map, each as one complex number that is linear in where the nodes are.

A point reads where the map has it. A ring of radius r around a point reads how the map turns and scales what lies
around that: over four points p_k = p + r i^k with arms d_k = p_k - mean(p), it reads

    r Σ conj(d_k) z(p_k) / Σ |d_k|²,

r times the similarity part of the linear map that is closest to z there  [FAT eq. 1 over four points]: where the end of
an arm of length r would be. It does not see a shift, nor a shear. So a ring is one linear constraint, like a point.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints, Points
from core.grid import Grid
from core.mapping.jacobians import Complexes, as_complex, as_positions

RING = 4
"""Points of a ring."""


@dataclass(frozen=True, eq=False)
class Probes:
    """Points of the picture, and rings around some."""

    at: Points
    """(k, 2), pixels of the picture."""
    radius: Floats
    """Of each ring (k,), 0 for a point."""

    @classmethod
    def of_points(cls, at: Points) -> "Probes":
        """Return points (k, 2) without rings."""
        return cls(at, np.zeros(len(at)))

    def __len__(self) -> int:
        return len(self.at)

    def __getitem__(self, chosen: Ints | Bools | slice) -> "Probes":
        return Probes(self.at[chosen], self.radius[chosen])

    def is_same(self, other: "Probes") -> bool:
        """Return whether the others are the same ones in the same order."""
        return np.array_equal(self.at, other.at) and np.array_equal(self.radius, other.radius)

    @property
    def are_rings(self) -> Bools:
        """Which of them (k,) are rings."""
        return self.radius > 0

    def spread(self, grid: Grid) -> "tuple[Points, scipy.sparse.csr_array]":
        """Return points of the picture (m, 2), and by what they make up the probes (k, m): real without rings."""
        single, ringed = np.flatnonzero(~self.are_rings), np.flatnonzero(self.are_rings)
        around = self._around(grid, ringed)
        points = np.concatenate([self.at[single], as_positions(around).reshape(-1, 2)])
        rows = np.concatenate([single, np.repeat(ringed, RING)])
        by = np.ones(len(single))
        if ringed.size:
            by = np.concatenate([by, self._shares(around, ringed).ravel()])
        return points, scipy.sparse.csr_array((by, (rows, np.arange(len(rows)))), (len(self), len(rows)))

    @lru_cache(maxsize=8)  # noqa: B019  a few: those that are read in every frame of a drag
    def on(self, grid: Grid) -> tuple[Ints, Floats | Complexes]:
        """Return the nodes (k, s) of the grid that they read, and with which weights; s is 4 without rings."""
        nodes, weights = grid.weights_at(self.at)
        ringed = np.flatnonzero(self.are_rings)
        if not ringed.size:
            return nodes, weights
        around = self._around(grid, ringed)
        far, shares = grid.weights_at(as_positions(around).reshape(-1, 2))
        wide, found = np.repeat(nodes, RING, axis=1), np.zeros((len(nodes), 4 * RING), np.complex128)
        found[:, ::RING] = weights
        wide[ringed] = far.reshape(-1, 4 * RING)
        found[ringed] = (self._shares(around, ringed)[..., None] * shares.reshape(-1, RING, 4)).reshape(-1, 4 * RING)
        return wide, found

    def read(self, grid: Grid, z: Complexes) -> Complexes:
        """Return what they read (k,) of nodes at z (R, C)."""
        nodes, weights = self.on(grid)
        return np.asarray((z.ravel()[nodes] * weights).sum(axis=1), np.complex128)

    def _around(self, grid: Grid, ringed: Ints) -> Complexes:
        """Return the points of rings (n, 4), those beyond the picture's edge at it."""
        far = self.radius[ringed, None] * np.array([1, 1j, -1, -1j])
        points = as_positions(as_complex(self.at[ringed])[:, None] + far)
        return as_complex(np.clip(points, -0.5, [grid.width_px - 0.5, grid.height_px - 0.5]))

    def _shares(self, around: Complexes, ringed: Ints) -> Complexes:
        """Return by what the points `around` (n, 4) make up the readings of rings."""
        arms = around - around.mean(axis=1, keepdims=True)
        square = (np.abs(arms) ** 2).sum(axis=1, keepdims=True)
        return np.asarray(self.radius[ringed, None] * np.conj(arms) / square)
