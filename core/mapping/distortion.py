"""Penalties on folded corners of quads, for Newton's method.

Every corner spans a triangle with its two neighbours. Measured against the same corner under W, it undergoes a linear
map J with determinant D; a quad is folded when one of its D is not positive.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from core.arrays import Floats, Ints
from core.mapping.frames import Complexes

_SIZE = 0.5
"""c of the barrier: what keeps corners from collapsing to a point."""

# T takes the positions of a quad's corners (x0, y0, ..., x3, y3) to the two edges at each corner: ahead, behind.
_EDGES = np.zeros((4, 4, 8))
for _k in range(4):
    for _axis in (0, 1):
        _EDGES[_k, _axis, 2 * ((_k + 1) % 4) + _axis] += 1
        _EDGES[_k, 2 + _axis, 2 * ((_k - 1) % 4) + _axis] += 1
        _EDGES[_k, [_axis, 2 + _axis], 2 * _k + _axis] -= 1


@dataclass(frozen=True)
class Corners:
    """The corners of m quads under W: what maps their edges now to their J."""

    a: Floats
    """J's first column is a[..., 0] ahead + a[..., 1] behind: (m, 4, 2)."""
    b: Floats
    area: Floats
    """Signed area under W (m, 4)."""

    @classmethod
    def of(cls, w: Complexes) -> "Corners":
        """Measure quads with corners w (m, 4), clockwise."""
        ahead, behind = edges_of(w)
        area = (np.conj(ahead) * behind).imag
        a = np.stack([behind.imag, -ahead.imag], axis=-1) / area[..., None]
        b = np.stack([-behind.real, ahead.real], axis=-1) / area[..., None]
        return cls(a, b, area)

    def of_quads(self, chosen: Ints) -> "Corners":
        """Return those of some of the quads."""
        return Corners(self.a[chosen], self.b[chosen], self.area[chosen])

    def determinants(self, z: Complexes) -> Floats:
        """Return D (m, 4) for quads with corners z (m, 4)."""
        ahead, behind = edges_of(z)
        return np.asarray((np.conj(ahead) * behind).imag / self.area)

    def jacobians(self, ahead: Complexes, behind: Complexes) -> tuple[Complexes, Complexes]:
        """Return the two columns of J (m, 4) for the edges at each corner."""
        return (
            self.a[..., 0] * ahead + self.a[..., 1] * behind,
            self.b[..., 0] * ahead + self.b[..., 1] * behind,
        )

    def slopes(self, ahead: Complexes, behind: Complexes) -> Floats:
        """Return dD by the x and y of the edge ahead, then of the one behind: (m, 4, 4)."""
        return np.stack([behind.imag, -behind.real, -ahead.imag, ahead.real], axis=-1) / self.area[..., None]


def edges_of(z: Complexes) -> tuple[Complexes, Complexes]:
    """Return the edges that lead ahead and back from each corner of quads z (m, 4)."""
    ahead = np.roll(z, -1, axis=1) - z
    return ahead, -np.roll(ahead, 1, axis=1)


class Penalty(Protocol):
    """An energy of quads with corners z (m, 4)."""

    def energy(self, corners: Corners, z: Complexes) -> Floats:
        """Return the energy of every quad (m,)."""

    def model(self, corners: Corners, z: Complexes) -> tuple[Floats, Floats]:
        """Return its gradient (m, 8) and a positive semidefinite second derivative (m, 8, 8), by corner x, y."""


@dataclass(frozen=True)
class Hinge:
    """f = ½ max(0, δ - D)², in the Gauss-Newton form: quick where folds are shallow."""

    least: float
    """δ, the share of its area under W that a corner is to keep."""

    def energy(self, corners: Corners, z: Complexes) -> Floats:
        """Return the energy of every quad (m,)."""
        gap = np.maximum(0, self.least - corners.determinants(z))
        return np.asarray((gap**2).sum(axis=1) / 2)

    def model(self, corners: Corners, z: Complexes) -> tuple[Floats, Floats]:
        """Return its gradient (m, 8) and a positive semidefinite second derivative (m, 8, 8), by corner x, y."""
        gradient, curvature = np.zeros((len(z), 8)), np.zeros((len(z), 8, 8))
        gap = np.maximum(0, self.least - corners.determinants(z))
        thin = np.flatnonzero(gap.any(axis=1))
        gap = gap[thin]
        slopes = corners.of_quads(thin).slopes(*edges_of(z[thin]))
        rows = np.einsum("mke,kej->mkj", slopes, _EDGES) * (gap > 0)[..., None]
        gradient[thin] = -np.einsum("mk,mkj->mj", gap, rows)
        curvature[thin] = rows.transpose(0, 2, 1) @ rows
        return gradient, curvature


@dataclass(frozen=True)
class Barrier:
    """The regularised distortion of Garanzha et al. 2021, finite on folds and steep towards them.

    f = (½ |J|² + c) / χ(D), χ(D) = (D + √(D² + ε²)) / 2, becomes a barrier against D = 0 as ε vanishes. Without the
    curvature of χ and of D, which are not convex, its second derivative is the square

        (1/χ) |dJ - (χ'/χ) J dD|² + (2 c χ'² / χ³) dD²,      χ'/χ = 1 / √(D² + ε²).
    """

    epsilon: float

    def energy(self, corners: Corners, z: Complexes) -> Floats:
        """Return the energy of every quad (m,)."""
        ahead, behind = edges_of(z)
        x, y = corners.jacobians(ahead, behind)
        D = corners.determinants(z)
        chi = (D + np.hypot(D, self.epsilon)) / 2
        return np.asarray(((0.5 * (np.abs(x) ** 2 + np.abs(y) ** 2) + _SIZE) / chi).sum(axis=1))

    def model(self, corners: Corners, z: Complexes) -> tuple[Floats, Floats]:
        """Return its gradient (m, 8) and a positive semidefinite second derivative (m, 8, 8), by corner x, y."""
        ahead, behind = edges_of(z)
        x, y = corners.jacobians(ahead, behind)
        D = corners.determinants(z)
        root = np.hypot(D, self.epsilon)
        chi = (D + root) / 2
        dD = corners.slopes(ahead, behind)
        J = np.stack([x.real, x.imag, y.real, y.imag], axis=-1)
        dJ = np.zeros((*D.shape, 4, 4))
        dJ[..., 0, ::2] = dJ[..., 1, 1::2] = corners.a
        dJ[..., 2, ::2] = dJ[..., 3, 1::2] = corners.b
        energy = (0.5 * (J**2).sum(axis=-1) + _SIZE) / chi
        slope = ((J / chi[..., None])[..., None, :] @ dJ)[..., 0, :] - (energy / root)[..., None] * dD
        rows = np.empty((*D.shape, 5, 4))
        rows[..., :4, :] = dJ - (J / root[..., None])[..., None] * dD[..., None, :]
        rows[..., 4, :] = (np.sqrt(2 * _SIZE) / root)[..., None] * dD
        rows = ((rows / np.sqrt(chi)[..., None, None]) @ _EDGES).reshape(len(D), 20, 8)
        return np.einsum("mke,kej->mj", slope, _EDGES), rows.transpose(0, 2, 1) @ rows
