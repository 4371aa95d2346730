"""The barrier that keeps the corners of quads from folding  [Garanzha et al. 2021, "Foldover-free maps in 50 lines"].

Every corner spans a triangle with its two neighbours. Against the same corner of a map without folds it undergoes a
linear map J with determinant D; a quad is folded when one of its D is not positive. Its energy is

    f = A / χ(D),   A = (|J|² + 1 + D²) / 2,   χ(D) = (D + √(D² + ε²)) / 2,

finite on folds, and a barrier against D = 0 as ε vanishes. J = 1 is stationary: where nothing is wrong, it pushes
nothing. With r = √(D² + ε²) and χ' = χ / r, dropping χ'' and the second derivative of D, which are not convex,

    df = (dA - (A / r) dD) / χ,     dA = ½ d|J|² + D dD,
    d²f ≈ (½ d²|J|² + dD dD - (dA dD + dD dA) / r + 2 (A / r²) dD dD) / χ.

That is a sum of squares: A = ½ Σ u² over the four entries of J, D and 1, so that it is Σ (du - u dD / r)² / χ.

Corners come first: what there is of m quads is (4, m), clockwise, so that the same corner of all quads lies together.
"""

import numpy as np

from core.arrays import Bools, Floats
from core.linalg.assembly import pack
from core.mapping.jacobians import Complexes
from core.mapping.tolerances import LITTLE

# Takes the positions of a quad's corners (x0, y0, ..., x3, y3) to the two edges at each corner: ahead, behind.
_EDGES = np.zeros((4, 4, 8))
for _k in range(4):
    for _axis in (0, 1):
        _EDGES[_k, _axis, 2 * ((_k + 1) % 4) + _axis] += 1
        _EDGES[_k, 2 + _axis, 2 * ((_k - 1) % 4) + _axis] += 1
        _EDGES[_k, [_axis, 2 + _axis], 2 * _k + _axis] -= 1
_PAIRS = [(i, j) for i in range(4) for j in range(i, 4)]
# Takes the upper triangles of four matrices over a corner's edges to the one over the quad's corners: (40, 36).
_SUM = pack(
    np.concatenate(
        [[np.outer(E[i], E[j]) + (np.outer(E[j], E[i]) if i != j else 0.0) for i, j in _PAIRS] for E in _EDGES]
    )
)


def edges_of(z: Complexes) -> tuple[Complexes, Complexes]:
    """Return the edges that lead ahead and back from each corner of quads z (4, m)."""
    ahead = z[[1, 2, 3, 0]]
    ahead -= z
    return ahead, -ahead[[3, 0, 1, 2]]


class AreaBarrier:
    """f of the corners of quads, measured against corners `shape` (4, m) of a map without folds.

    Of the quads `single` (m,) only the first corner counts: they stand for corners that no quad of this grid has.
    """

    def __init__(self, shape: Complexes, single: Bools) -> None:
        ahead, behind = edges_of(_open_up(shape, single))
        product = np.conj(ahead) * behind
        self._left_out = np.zeros(shape.shape, bool)
        self._left_out[1:, single] = True
        # What is left out has J = 0 and D = 1 everywhere: a constant.
        self._inverse = np.where(self._left_out, 0.0, 1 / np.where(self._left_out, 1.0, product.imag))
        self._metric = np.stack([np.abs(behind) ** 2, -product.real, np.abs(ahead) ** 2]) * self._inverse**2

    def determinants(self, z: Complexes) -> Floats:
        """Return D (4, m) for quads with corners z (4, m)."""
        return self._determinants(*edges_of(z))

    def _determinants(self, ahead: Complexes, behind: Complexes) -> Floats:
        D = (ahead.real * behind.imag - ahead.imag * behind.real) * self._inverse
        D[self._left_out] = 1.0
        return np.asarray(D)

    def _strains(self, ahead: Complexes, behind: Complexes) -> tuple[Complexes, Complexes]:
        """Return half the slope of |J|² by each of the two edges."""
        p, q, r = self._metric
        return p * ahead + q * behind, q * ahead + r * behind

    def energy(self, z: Complexes, epsilon: float) -> tuple[float, float]:
        """Return the sum of f and the least D."""
        ahead, behind = edges_of(z)
        D = self._determinants(ahead, behind)
        one, two = self._strains(ahead, behind)
        A = _size(one, two, ahead, behind, D)
        return float((A / _softened(D, np.hypot(D, epsilon), epsilon)).sum()), float(D.min(initial=np.inf))

    def model(self, z: Complexes, epsilon: float) -> tuple[Floats, Floats]:
        """Return the gradient (m, 8) and the second derivative, packed (m, 36), by the x and y of the corners."""
        ahead, behind = edges_of(z)
        D = self._determinants(ahead, behind)
        one, two = self._strains(ahead, behind)
        A, root = _size(one, two, ahead, behind, D), np.hypot(D, epsilon)
        chi = _softened(D, root, epsilon)
        g = [part / chi for part in (one.real, one.imag, two.real, two.imag)]
        dD = [part * self._inverse for part in (behind.imag, -behind.real, -ahead.imag, ahead.real)]
        slope = (D - A / root) / chi
        along = [a + slope * b for a, b in zip(g, dD, strict=True)]
        # -g dD - dD g, over r, and the square of dD in one.
        half = (0.5 - D / root + A / root**2) / chi
        mixed = [half * b - a / root for a, b in zip(g, dD, strict=True)]
        curvature = np.empty((4, len(_PAIRS), z.shape[1]))
        for entry, (i, j) in enumerate(_PAIRS):
            value = mixed[i] * dD[j] + mixed[j] * dD[i]
            if i % 2 == j % 2:
                value += self._metric[i // 2 + j // 2] / chi
            curvature[:, entry] = value
        gradient = np.stack(along, axis=1).reshape(16, -1).T @ _EDGES.reshape(16, 8)
        return gradient, curvature.reshape(40, -1).T @ _SUM


def _open_up(shape: Complexes, single: Bools) -> Complexes:
    """Return quads (4, m) with those that all but fold at a corner opened to the parallelogram of their mean edges."""
    ahead, behind = edges_of(shape)
    areas = (np.conj(ahead) * behind).imag
    thin = np.flatnonzero((areas.min(axis=0) < LITTLE * areas.mean(axis=0)) & ~single)
    opened, (a, b, c, d) = shape.copy(), shape[:, thin]
    across, down = (b - a + c - d) / 4, (d - a + c - b) / 4
    opened[:, thin] = (a + b + c + d) / 4 + np.stack([-across - down, across - down, across + down, down - across])
    return opened


def _size(one: Complexes, two: Complexes, ahead: Complexes, behind: Complexes, D: Floats) -> Floats:
    """Return A of every corner (4, m)."""
    square = one.real * ahead.real + one.imag * ahead.imag + two.real * behind.real + two.imag * behind.imag
    return np.asarray((square + 1 + D * D) / 2)


def _softened(D: Floats, root: Floats, epsilon: float) -> Floats:
    """Return χ; for D < 0 in a form that does not cancel."""
    return np.where(D > 0, D + root, epsilon**2 / np.where(D > 0, 1.0, root - D)) / 2
