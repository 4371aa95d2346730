"""Features that move as one similarity each: what FAT asks for, exactly.

Unknown are the free nodes and every feature's similarity (α, t), together c, which places its nodes at Φ c. With z⁰ = W
on outline and free nodes and 0 on features, nodes end at z = z⁰ + v + Φ c, where v lives on free nodes only. Quads that
follow W ask for d z = d W, those that follow a feature for d z = α d p; so the energy is

    ½ z* K z - Re z* (b + H c) + ½ c* D c,      K = dᵀ w d,  b = dᵀ w d W,  H = dᵀ w d p for α and 0 for t.

Its gradient vanishes where, with r = b - K z⁰, B = H - K Φ, and f marking the rows of free nodes,

    K_ff v = r_f + B_f c
    (G - B_f* K_ff⁻¹ B_f) c = Φ* r + H* z⁰ + B_f* K_ff⁻¹ r_f,      G = D - Φ* B - H* Φ.

K_ff is real and depends on grid and mask alone: it is factorised once per mask, and so are the few columns B. A new W
costs a pair of substitutions and a system as small as the number of features. Where |α| is given, the phases settle in
a few rounds of that small system.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from core.arrays import Bools, Floats, Ints
from core.factor import Factor
from core.mapping.frames import Complexes
from core.mapping.similarity import Body
from core.mapping.stencil import EdgeWeights, divergence, edge_weights, laplacian

_TIE = 1e-7
"""Weight of a tie of feature nodes to W; it decides only where no free node does."""
_ROUNDS = 50


class Placement:
    """The reduced system of (α, t) over a factorised grid.

    Parameters
    ----------
    bodies
        The features to place.
    rest
        Rest positions (R, C).
    owner
        Index into `bodies` of the feature that each quad (R-1, C-1) follows, -1 for none.
    follow
        Weight of each quad's equations of type FAT eq. 3, squared.
    weights
        Of the edges, from equations of both types.
    free
        Nodes (R, C) that are neither on the outline nor in a feature.
    factor
        Of K_ff, with the equation x = 0 on all other nodes.
    """

    def __init__(
        self,
        bodies: list[Body],
        rest: Complexes,
        *,
        owner: Ints,
        follow: Floats,
        weights: EdgeWeights,
        free: Bools,
        factor: Factor,
    ) -> None:
        self._factor, self._free = factor, free.ravel()
        self._count = count = len(bodies)
        fields = [_field(b, rest, owner == i, follow, weights) for i, b in enumerate(bodies)]
        nodes = [f.nodes for f in fields]
        phi = _columns(nodes, [f.phi[0] for f in fields], [f.phi[1] for f in fields], rest.size)
        H = _columns(nodes, [f.halo for f in fields], [f.halo * 0 for f in fields], rest.size)
        B = _columns(nodes, [f.load[0] for f in fields], [f.load[1] for f in fields], rest.size)
        self._phi, self._halo = phi.conj().T.tocsr(), H.conj().T.tocsr()
        G = (_TIE * self._phi @ phi - self._phi @ B - self._halo @ phi).toarray()
        G[np.arange(count), np.arange(count)] += [f.stiffness for f in fields]
        self._half = _forward(factor, B.toarray() * self._free[:, None], count)
        S = G - self._half.conj().T @ self._half
        self._S = (S + S.conj().T) / 2

    def solve(
        self, r: Complexes, z0: Complexes, warped: Complexes, scales: Floats | None, given: Complexes | None = None
    ) -> tuple[Complexes, Complexes]:
        """Return c = (α, t) and v (N,) for the load r, the start z⁰ and W, all (N,).

        |α| = `scales` where they are given, c = `given` where that is.
        """
        load = np.where(self._free, r, 0)
        y = as_one(self._factor.forward(as_two(load)))
        g = np.asarray(self._phi @ (r + _TIE * warped) + self._halo @ z0 + self._half.conj().T @ y, np.complex128)
        c = self._minimise(g, scales) if given is None else given
        v = as_one(self._factor.backward(as_two(y + self._half @ c)))
        return c, np.where(self._free, v, 0)

    def _minimise(self, g: Complexes, scales: Floats | None) -> Complexes:
        """Minimise ½ c* S c - Re c* g, with |α| given or not."""
        n = self._count
        if scales is None:
            return np.linalg.solve(self._S, g).astype(np.complex128, copy=False)
        # Translations are eliminated; then each phase in turn has its best value in closed form.
        carry = np.linalg.solve(self._S[n:, n:], np.column_stack([self._S[n:, :n], g[n:]]))
        A = self._S[:n, :n] - self._S[:n, n:] @ carry[:, :n]
        gamma = g[:n] - self._S[:n, n:] @ carry[:, n]
        alpha = _with_length(np.linalg.solve(A, gamma), scales)
        for _ in range(_ROUNDS):
            before = alpha.copy()
            for j in range(n):
                alpha[j] = _with_length(gamma[j] - A[j] @ alpha + A[j, j] * alpha[j], scales[j])
            if np.abs(alpha - before).max() < 1e-13 * scales.max():
                break
        t = carry[:, n] - carry[:, :n] @ alpha
        return np.concatenate([alpha, t]).astype(np.complex128, copy=False)


def _with_length(alpha: NDArray[Any], length: Floats) -> Complexes:
    """Scale complex numbers to the given lengths; 0 points along the real axis."""
    size = np.abs(alpha)
    unit: Complexes = np.where(size > 0, alpha / np.where(size > 0, size, 1), 1)
    return unit * length


def _forward(factor: Factor, columns: Complexes, count: int) -> Complexes:
    """Return L⁻¹ P B for complex columns of α and real columns of t, by real substitutions."""
    turning, shifting = columns[:, :count], columns[:, count:]
    half = factor.forward(np.concatenate([turning.real, turning.imag, shifting.real], axis=1))
    return np.concatenate([half[:, :count] + 1j * half[:, count : 2 * count], half[:, 2 * count :]], axis=1)


def as_two(z: Complexes) -> NDArray[np.float64]:
    """Return x + iy (N,) as two columns (N, 2)."""
    return z[:, None].view(np.float64)


def as_one(columns: NDArray[np.float64]) -> Complexes:
    """Return two columns (N, 2) as x + iy (N,)."""
    return np.ascontiguousarray(columns).view(np.complex128)[:, 0]


@dataclass(frozen=True)
class _Field:
    """What one feature contributes: columns over the nodes of a window around it."""

    nodes: Ints
    phi: tuple[Complexes, Complexes]
    """Φ for α and for t."""
    halo: Complexes
    """H for α."""
    load: tuple[Complexes, Complexes]
    """B for α and for t."""
    stiffness: float
    """D for α."""


def _field(body: Body, rest: Complexes, own: Bools, follow: Floats, weights: EdgeWeights) -> _Field:
    """Evaluate a feature's columns in the smallest window that its nodes, their neighbours and its own quads fill."""
    row, column = np.divmod(body.nodes, rest.shape[1])
    quad_row, quad_column = own.nonzero()
    top = max(min(row.min(), quad_row.min(initial=rest.shape[0])) - 1, 0)
    left = max(min(column.min(), quad_column.min(initial=rest.shape[1])) - 1, 0)
    bottom = max(row.max(), quad_row.max(initial=0) + 1) + 2
    right = max(column.max(), quad_column.max(initial=0) + 1) + 2
    window = np.s_[top:bottom, left:right]
    number = np.arange(rest.size).reshape(rest.shape)[window]
    place = np.searchsorted(number.ravel(), body.nodes)
    turned, shifted = np.zeros((2, *number.shape), np.complex128)
    turned.ravel()[place], shifted.ravel()[place] = body.arms, 1
    near = (weights[0][top:bottom, left : right - 1], weights[1][top : bottom - 1, left:right])
    quads = np.s_[top : bottom - 1, left : right - 1]
    halo_weights = edge_weights(np.where(own[quads], follow[quads], 0.0))
    across, down = np.diff(rest[window], axis=1), np.diff(rest[window], axis=0)
    halo = divergence(halo_weights[0] * across, halo_weights[1] * down)
    return _Field(
        number.ravel(),
        (turned.ravel(), shifted.ravel()),
        halo.ravel(),
        ((halo - laplacian(near, turned)).ravel(), -laplacian(near, shifted).ravel()),
        float((halo_weights[0] * np.abs(across) ** 2).sum() + (halo_weights[1] * np.abs(down) ** 2).sum()),
    )


def _columns(nodes: list[Ints], turning: list[Complexes], shifting: list[Complexes], size: int) -> sparse.csc_array:
    """Assemble the columns of all α, then of all t, as an (N, 2d) matrix."""
    values = np.concatenate(turning + shifting)
    starts = np.concatenate([[0], np.cumsum([len(n) for n in nodes + nodes])])
    return sparse.csc_array((values, np.concatenate(nodes + nodes), starts), shape=(size, 2 * len(nodes)))
