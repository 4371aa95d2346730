"""Penalties on folded corners of quads, for Newton's method.

Every corner spans a triangle with its two neighbours. Measured against the same corner under W, it undergoes a linear
map J with determinant D; a quad is folded when one of its D is not positive. Corners come first: what there is of m
quads is (4, m), so that the same corner of all quads lies together.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from core.arrays import Floats, Ints
from core.mapping.assembly import packed
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
_PAIRS = [(i, j) for i in range(4) for j in range(i, 4)]
# Takes the upper triangles of four matrices over a corner's edges to the one over the quad's corners: (40, 36).
_SUM = packed(
    np.concatenate(
        [[np.outer(E[i], E[j]) + (np.outer(E[j], E[i]) if i != j else 0.0) for i, j in _PAIRS] for E in _EDGES]
    )
)


@dataclass(frozen=True)
class Corners:
    """The corners of m quads under W: what their edges now are measured against."""

    metric: Floats
    """p, q and r (3, 4, m) of |J|² = p |ahead|² + 2 q ahead · behind + r |behind|²."""
    area: Floats
    """Signed area under W (4, m)."""

    @classmethod
    def of(cls, w: Complexes) -> "Corners":
        """Measure quads with corners w (4, m), clockwise."""
        ahead, behind = edges_of(w)
        product = np.conj(ahead) * behind
        area = product.imag.copy()
        return cls(np.stack([np.abs(behind) ** 2, -product.real, np.abs(ahead) ** 2]) / area**2, area)

    def of_quads(self, chosen: Ints) -> "Corners":
        """Return those of some of the quads."""
        return Corners(self.metric[..., chosen], self.area[:, chosen])

    def determinants(self, z: Complexes) -> Floats:
        """Return D (4, m) for quads with corners z (4, m)."""
        return self.determinants_of(*edges_of(z))

    def determinants_of(self, ahead: Complexes, behind: Complexes) -> Floats:
        """Return D (4, m) for the edges at each corner."""
        return np.asarray((ahead.real * behind.imag - ahead.imag * behind.real) / self.area)

    def slopes(self, ahead: Complexes, behind: Complexes) -> Floats:
        """Return dD by the x and y of the edge ahead, then of the one behind: (m, 4, 4), quads first."""
        slopes = np.stack([behind.imag, -behind.real, -ahead.imag, ahead.real]) / self.area
        return np.ascontiguousarray(slopes.transpose(2, 1, 0))

    def strains(self, ahead: Complexes, behind: Complexes) -> tuple[Complexes, Complexes]:
        """Return half the slope of |J|² by each of the two edges."""
        p, q, r = self.metric
        return p * ahead + q * behind, q * ahead + r * behind


def edges_of(z: Complexes) -> tuple[Complexes, Complexes]:
    """Return the edges that lead ahead and back from each corner of quads z (4, m)."""
    ahead = z[[1, 2, 3, 0]]
    ahead -= z
    return ahead, -ahead[[3, 0, 1, 2]]


class Penalty(Protocol):
    """An energy of quads with corners z (4, m)."""

    def energy(self, corners: Corners, z: Complexes) -> Floats:
        """Return the energy of every quad (m,)."""

    def model(self, corners: Corners, z: Complexes) -> tuple[Floats, Floats]:
        """Return its gradient (m, 8) and a positive semidefinite second derivative, packed (m, 36), by corner x, y."""


@dataclass(frozen=True)
class Hinge:
    """f = ½ max(0, δ - D)², in the Gauss-Newton form: quick where folds are shallow."""

    least: float
    """δ, the share of its area under W that a corner is to keep."""

    def energy(self, corners: Corners, z: Complexes) -> Floats:
        """Return the energy of every quad (m,)."""
        gap = np.maximum(0, self.least - corners.determinants(z))
        return np.asarray((gap**2).sum(axis=0) / 2)

    def model(self, corners: Corners, z: Complexes) -> tuple[Floats, Floats]:
        """Return its gradient (m, 8) and a positive semidefinite second derivative, packed (m, 36), by corner x, y."""
        gradient, curvature = np.zeros((z.shape[1], 8)), np.zeros((z.shape[1], 36))
        gap = np.maximum(0, self.least - corners.determinants(z))
        thin = np.flatnonzero(gap.any(axis=0))
        gap = gap[:, thin].T
        slopes = corners.of_quads(thin).slopes(*edges_of(z[:, thin]))
        rows = np.einsum("mke,kej->mkj", slopes, _EDGES) * (gap > 0)[..., None]
        gradient[thin] = -np.einsum("mk,mkj->mj", gap, rows)
        curvature[thin] = packed(rows.transpose(0, 2, 1) @ rows)
        return gradient, curvature


@dataclass(frozen=True)
class Barrier:
    """The regularised distortion of Garanzha et al. 2021, finite on folds and steep towards them.

    f = F / χ(D), F = ½ |J|² + c, χ(D) = (D + √(D² + ε²)) / 2, becomes a barrier against D = 0 as ε vanishes. Without
    the curvature of χ and of D, which are not convex, its second derivative is a square: with g = dF

        (1/χ) (d²F - s (g dD + dD g) + 2 s² F dD dD),      s = χ'/χ = 1 / √(D² + ε²).
    """

    epsilon: float

    def energy(self, corners: Corners, z: Complexes) -> Floats:
        """Return the energy of every quad (m,)."""
        ahead, behind = edges_of(z)
        D = corners.determinants_of(ahead, behind)
        return np.asarray((2 * _size(corners, ahead, behind) / (D + np.hypot(D, self.epsilon))).sum(axis=0))

    def model(self, corners: Corners, z: Complexes) -> tuple[Floats, Floats]:
        """Return its gradient (m, 8) and a positive semidefinite second derivative, packed (m, 36), by corner x, y."""
        ahead, behind = edges_of(z)
        D = corners.determinants_of(ahead, behind)
        root = np.hypot(D, self.epsilon)
        chi = (D + root) / 2
        share = _size(corners, ahead, behind) / (chi * root)
        one, two = corners.strains(ahead, behind)
        g = [part / chi for part in (one.real, one.imag, two.real, two.imag)]
        dD = [part / corners.area for part in (behind.imag, -behind.real, -ahead.imag, ahead.real)]
        along = [a - share * b for a, b in zip(g, dD, strict=True)]
        # g dD + dD g and the square of dD in one.
        mixed = [share / root * b - a / root for a, b in zip(g, dD, strict=True)]
        curvature = np.empty((4, len(_PAIRS), z.shape[1]))
        for entry, (i, j) in enumerate(_PAIRS):
            value = mixed[i] * dD[j] + mixed[j] * dD[i]
            if i % 2 == j % 2:
                value += corners.metric[i // 2 + j // 2] / chi
            curvature[:, entry] = value
        gradient = np.stack(along, axis=1).reshape(16, -1).T @ _EDGES.reshape(16, 8)
        return gradient, curvature.reshape(40, -1).T @ _SUM


def _size(corners: Corners, ahead: Complexes, behind: Complexes) -> Floats:
    """Return F of every corner (4, m)."""
    one, two = corners.strains(ahead, behind)
    there = one.real * ahead.real + one.imag * ahead.imag + two.real * behind.real + two.imag * behind.imag
    return np.asarray(there / 2 + _SIZE)
