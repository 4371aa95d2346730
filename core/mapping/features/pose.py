"""What a mapping with features knows before its free nodes follow: where features are, and which points are held."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints, Points
from core.linalg.cubic_convolution import Smooth
from core.linalg.grid_solver import HalfSolved, Onto
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
        """Return what the combinations (k,) are of `nodes` at z (m, 4)."""
        return np.asarray(self.M @ (z * self.weights).sum(axis=1), np.complex128)

    def moved_by(self, load: Any) -> Complexes:
        """Return by how much the combinations (k,) move under a load L⁻¹ P r (N, 2)."""
        x, y = (self.half.T @ load).T
        return np.asarray(self.M @ (x + 1j * y), np.complex128)

    def pull(self, missed: Complexes) -> Any:
        """Return the load that moves the combinations by what they `missed` (k,)."""
        forces = self._forces @ missed
        return self.half @ np.stack([forces.real, forces.imag], axis=1)


@dataclass(frozen=True, eq=False)
class HeldNodes:
    """The nodes of a grid that are not free: those of its outline and those of bodies."""

    bodies: Ints
    outline: Ints
    """Those of the outline outside bodies."""
    nodes: Ints
    """Of bodies, then of the outline (h,)."""
    place: Ints
    """The number of every node (R, C) among them, -1 for free ones."""

    @classmethod
    def of(cls, bodies: Ints, outline: Bools) -> "HeldNodes":
        """Return them, given the nodes of all bodies."""
        place = np.full(outline.shape, -1)
        place.ravel()[bodies] = 0
        others = np.flatnonzero(outline & (place < 0))
        nodes = np.concatenate([bodies, others])
        place.ravel()[nodes] = np.arange(len(nodes))
        return cls(bodies, others, nodes, place)


@dataclass(frozen=True, eq=False)
class Start:
    """Where nodes are before the free ones follow: these where W has them."""

    w: Smooth
    held: HeldNodes
    at_held: Complexes
    """Where the others are (h,)."""

    def read(self, nodes: Ints) -> Complexes:
        """Return where some nodes (...) are."""
        place = self.held.place.ravel()[nodes]
        return np.asarray(np.where(place >= 0, self.at_held[place], self.w.read(nodes)))

    @property
    def onto(self) -> Onto:
        """What free nodes move from, and where all others stay."""
        return Onto(self.w.whole, None, self.held.nodes, self.at_held)

    def with_first(self, first: Complexes) -> "Start":
        """Return this start with the first of the held nodes elsewhere."""
        return replace(self, at_held=np.concatenate([first, self.at_held[len(first) :]]))


@dataclass(frozen=True, eq=False)
class Pose:
    """Where the bodies are for one W, before the free nodes follow them."""

    alpha: Complexes
    t: Complexes
    w: Complexes
    start: Start
    """What the free nodes move from."""
    load: Any
    """What moves them beside the bodies that found their place."""
    moving: Ints
    """These bodies."""


@dataclass(frozen=True, eq=False)
class Approach:
    """A mapping before free nodes follow, and before points are held."""

    w: Smooth
    """What the free nodes move from."""
    load: Any
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
    folded: Bools | None = None
    """Which quads (R-1, C-1) are folded, where that is known."""

    @property
    def positions(self) -> Points:
        """Node positions (R, C, 2)."""
        return as_positions(self.z)
