"""A picture that handles displace, and what large rotations make of it before that, as `plate` has it."""

from dataclasses import dataclass

import numpy as np

from core.arrays import Floats
from core.mapping.jacobians import Complexes


@dataclass(frozen=True, eq=False)
class Base:
    """Where a picture that is displaced has the plate's nodes, z⁰ (r, c); what its rotation is measured against."""

    z: Complexes
    right: Complexes
    below: Complexes
    """Edges across and down."""
    across: Complexes
    down: Complexes
    """Their sums on every quad (r-1, c-1), conjugated."""

    @classmethod
    def of(cls, z: Complexes) -> "Base":
        """Evaluate edges."""
        right, below = _edges(z)
        across, down = _sums(right, below)
        return cls(z, right, below, across.conj(), down.conj())

    def rotations(self, z: Complexes) -> Complexes:
        """Return the local rotation (r-1, c-1) of z (r, c) against z⁰ on every quad, as unit complex numbers.

        With X and Y the sums of a quad's edges across and down, its linear part is u -> (X - iY) u + (X + iY) conj(u),
        but for the cell's size. So the similarity part of L L0⁻¹ is, but for its size, i (X conj(Y0) - Y conj(X0)).
        """
        x, y = _sums(*_edges(z))
        part = 1j * (x * self.down - y * self.across)
        size = np.sqrt(part.real**2 + part.imag**2)
        return np.divide(part, size, out=np.ones_like(part), where=size > 0)


@dataclass(frozen=True, eq=False)
class Turned:
    """What large rotations make of a picture without handles, which a displacement is added to."""

    y: Complexes
    """Displacements (r, c)."""
    normals: Complexes
    bends: Floats
    """Of the rods, n and b (k,)."""
    slides: bool
    """Whether the frame slides with rods that end on it."""

    def differs_px(self, other: "Turned") -> float:
        """Return by how much at most another one takes a node elsewhere, or bends rods otherwise."""
        parts = np.abs(self.y - other.y), np.abs(self.bends - other.bends)
        return max(float(part.max(initial=0)) for part in parts)


def _edges(z: Complexes) -> tuple[Complexes, Complexes]:
    """Return the edges across (r, c-1) and down (r-1, c) of z (r, c)."""
    return z[:, 1:] - z[:, :-1], z[1:] - z[:-1]


def _sums(right: Complexes, below: Complexes) -> tuple[Complexes, Complexes]:
    """Return the sums of the edges across and down of every quad (r-1, c-1)."""
    return right[1:] + right[:-1], below[:, 1:] + below[:, :-1]
