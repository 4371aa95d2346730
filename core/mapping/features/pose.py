"""What a mapping with features knows before its free nodes follow: where features are, and which points are held."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from core.arrays import Floats, Ints, Points
from core.linalg.grid_solver import HalfSolved
from core.mapping.jacobians import Complexes, as_positions


@dataclass(frozen=True, eq=False)
class HeldPoints:
    """Combinations of points of the picture that a mapping's free nodes hold: their small dense system."""

    nodes: Ints
    weights: Floats
    """Corners of the points' quads and their bilinear weights (m, 4)."""
    M: "scipy.sparse.csr_array"
    """The combinations (k, m)."""
    half: HalfSolved
    """L⁻¹ P Cᵀ (N, m)."""
    inverse: Floats | Complexes
    """(M C K_ff⁻¹ Cᵀ M*)⁻¹ (k, k)."""

    @cached_property
    def _forces(self) -> Complexes:
        """M* times the inverse (m, k)."""
        return np.asarray(self.M.conj().T @ self.inverse, np.complex128)

    def read(self, z: Complexes) -> Complexes:
        """Return what the combinations (k,) are of nodes at z (R, C)."""
        return np.asarray(self.M @ (z.ravel()[self.nodes] * self.weights).sum(axis=1), np.complex128)

    def moved_by(self, load: Floats) -> Complexes:
        """Return by how much the combinations (k,) move under a load L⁻¹ P r (N, 2)."""
        x, y = (self.half.T @ load).T
        return np.asarray(self.M @ (x + 1j * y), np.complex128)

    def pull(self, missed: Complexes) -> Floats:
        """Return the load (N, 2) that moves the combinations by what they `missed` (k,)."""
        forces = self._forces @ missed
        return np.asarray(self.half @ np.stack([forces.real, forces.imag], axis=1))


@dataclass(frozen=True, eq=False)
class Pose:
    """Where the bodies are for one W, before the free nodes follow them."""

    alpha: Complexes
    t: Complexes
    w: Complexes
    start: Complexes
    """Node positions (R, C) that the free nodes move from."""
    load: Floats
    """What moves them beside the bodies that found their place."""
    moving: Ints
    """These bodies."""


@dataclass(frozen=True, eq=False)
class Approach:
    """A mapping before free nodes follow, and before points are held."""

    start: Complexes
    """Node positions (R, C) that the free nodes move from."""
    load: Floats
    """What moves them."""
    missed: Complexes
    """How far from their goals the points would then be (k,)."""


@dataclass(frozen=True, eq=False)
class Solution:
    """A mapped grid with the similarity of each of its bodies."""

    z: Complexes
    """Node positions (R, C)."""
    alpha: Complexes
    t: Complexes
    """Body i lies at alpha[i] * arms + t[i]; both are empty for the per-quad method."""

    @property
    def positions(self) -> Points:
        """Node positions (R, C, 2)."""
        return as_positions(self.z)
