"""What a mapping with features knows before its free nodes follow: where features are, and which points are held."""

from dataclasses import dataclass

import numpy as np

from core.arrays import Floats, Ints
from core.mapping.jacobians import Complexes


@dataclass(frozen=True, eq=False)
class HeldPoints:
    """Points of the picture that a mapping's free nodes hold: their small dense system."""

    nodes: Ints
    weights: Floats
    """Corners of the points' quads and their bilinear weights (k, 4)."""
    half: Floats
    """L⁻¹ P Cᵀ (N, k)."""
    inverse: Floats
    """(C K_ff⁻¹ Cᵀ)⁻¹ (k, k)."""

    def places(self, z: Complexes) -> Complexes:
        """Return where nodes at z (R, C) have the points (k,)."""
        return np.asarray((z.ravel()[self.nodes] * self.weights).sum(axis=1), np.complex128)


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
