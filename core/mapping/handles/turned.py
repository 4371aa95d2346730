"""A picture that handles displace, and what large rotations make of it before that, as `plate` has it."""

from dataclasses import dataclass

import numpy as np

from core.arrays import Floats
from core.linalg.laplacian import collect_steps, steps
from core.mapping.jacobians import Complexes


@dataclass(frozen=True, eq=False)
class Base:
    """Where a picture that is displaced has the plate's nodes, z⁰ (r, c); what its rotation is measured against."""

    z: Complexes
    right: Complexes
    below: Complexes
    """Edges across and down, as `laplacian.steps` has them."""
    falling: Complexes
    rising: Complexes
    """Diagonals of every quad, i times their conjugates."""

    @classmethod
    def of(cls, z: Complexes) -> "Base":
        """Evaluate edges and diagonals."""
        falling, rising = _diagonals(z)
        return cls(z, *steps(z.ravel(), z.shape[1]), 1j * falling.conj(), 1j * rising.conj())

    def turn(self, z: Complexes) -> Complexes:
        """Return dᵀ (r - 1) d z⁰ at the nodes (r, c), summed over quads, r the local rotation of z (r, c) against z⁰.

        With X and Y the sums of a quad's edges across and down, its linear part is u -> (X - iY) u + (X + iY) conj(u),
        but for the cell's size. So the similarity part of L L0⁻¹ is, but for its size, i (X conj(Y0) - Y conj(X0)), or,
        by the diagonals P = X + Y and Q = X - Y, i (Q conj(P0) - P conj(Q0)).
        """
        rows, columns = z.shape
        falling, rising = _diagonals(z)
        part = rising * self.falling - falling * self.rising
        size = np.abs(part)
        flat = size == 0
        if flat.any():
            part[flat] = size[flat] = 1
        turned = np.zeros((rows - 1, columns), np.complex128)
        each = turned.ravel()
        np.multiply(part, 1 / size, out=each[:-1])
        each -= 1
        turned[:, -1] = 0
        across, down = np.zeros(z.size, np.complex128), each.copy()
        across[:-columns] = each
        across[columns:] += each
        down[1:] += each[:-1]
        return collect_steps(across[:-1] * self.right, down * self.below).reshape(z.shape)


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


def _diagonals(z: Complexes) -> tuple[Complexes, Complexes]:
    """Return the diagonals from the top left and from the bottom left of every quad of z (r, c), row by row.

    What lies between the end of a row and the beginning of the next one counts as a quad.
    """
    each, columns = z.ravel(), z.shape[1]
    return each[columns + 1 :] - each[: -columns - 1], each[1:-columns] - each[columns:-1]
