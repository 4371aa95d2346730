"""A picture that handles displace, and what large rotations make of it before that, as `plate` has it."""

from dataclasses import dataclass

import numpy as np

from core.arrays import Floats
from core.grid import Grid
from core.mapping.jacobians import Complexes, Jacobians, linear_parts


@dataclass(frozen=True, eq=False)
class Base:
    """A picture that is displaced, z⁰ (R, C), and what its local rotation is measured against."""

    z: Complexes
    parts: Jacobians
    right: Complexes
    below: Complexes
    """Edges across and down."""

    @classmethod
    def of(cls, grid: Grid, z: Complexes) -> "Base":
        """Evaluate linear parts and edges."""
        return cls(z, linear_parts(grid, z), np.diff(z, axis=1), np.diff(z, axis=0))


@dataclass(frozen=True, eq=False)
class Turned:
    """What large rotations make of a picture without handles, which a displacement is added to."""

    y: Complexes
    """Displacements (R, C)."""
    normals: Complexes
    bends: Floats
    """Of the rods, n and b (k,)."""
    slides: bool
    """Whether the frame slides with rods that end on it."""

    def differs_px(self, other: "Turned") -> float:
        """Return by how much at most another one takes a node elsewhere, or bends rods otherwise."""
        parts = np.abs(self.y - other.y), np.abs(self.bends - other.bends)
        return max(float(part.max(initial=0)) for part in parts)


def rotations(before: Jacobians, after: Jacobians) -> Complexes:
    """Return the local rotation (R-1, C-1) of a mapping against another one on every quad, as unit complex numbers."""
    # J = L L0⁻¹ with L u = a u + b conj(u); its similarity part is (a conj(a0) - b conj(b0)) / det L0.
    part = after.similar * before.similar.conj() - after.opposite * before.opposite.conj()
    size = np.abs(part)
    return np.divide(part, size, out=np.ones_like(part), where=size > 0)
