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
a few rounds of that small system. Features may also be held where they are: their c is then data, not unknown, and
their columns are not needed.

Weights are real, so with arms p = x + iy the columns for α are those of x plus i times those of y. Kept are the real
columns of x, y and 1, B' and so on; then B = B' U, where U takes (α, t) to (α, iα, t).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from core.arrays import Bools, Floats, Ints
from core.mapping.frames import Complexes
from core.mapping.grid_factor import MappingFactor
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
        factor: MappingFactor,
    ) -> None:
        self._factor, self._free = factor, free.ravel()
        self._count = count = len(bodies)
        fields = [_field(b, rest, owner == i, follow, weights) for i, b in enumerate(bodies)]
        nodes = [f.nodes for f in fields]
        phi = _columns(nodes, [*(f.phi for f in fields), *(f.phi_t for f in fields)], rest.size)
        halo = _columns(nodes, [*(f.halo for f in fields), *(0 * f.halo for f in fields)], rest.size)
        turning, shifting = [f.load for f in fields], [f.load_t for f in fields]
        self._B = _columns(nodes, [*(f.real for f in turning), *(f.imag for f in turning), *shifting], rest.size)
        self._phi, self._halo = phi.conj().T.tocsr(), halo.conj().T.tocsr()
        U = _spread(np.eye(2 * count, dtype=np.complex128), count)
        self._G = (_TIE * self._phi @ phi - self._halo @ phi).toarray() - (self._phi @ self._B).toarray() @ U
        self._G[np.arange(count), np.arange(count)] += [f.stiffness for f in fields]
        self._reduced: _Reduced | None = None

    def solve(
        self,
        r: Complexes,
        z0: Complexes,
        warped: Complexes,
        scales: Floats | None,
        *,
        given: Complexes,
        moving: Ints,
    ) -> tuple[Complexes, Complexes]:
        """Return c = (α, t) and v (N,) for the load r, the start z⁰ and W, all (N,).

        The features `moving` find their place, with |α| = `scales` where they are given; the others have that of
        `given`, (α, t).
        """
        chosen = np.concatenate([moving, self._count + moving])
        c = given.copy()
        c[chosen] = 0
        load = np.where(self._free, r + np.asarray(self._B @ _spread(c, self._count)), 0)
        y = as_one(self._factor.forward_again(as_two(load)))
        if moving.size:
            reduced = self.prepare(moving)
            g = self._phi @ (r + _TIE * warped) + self._halo @ z0 - self._G @ c
            g = g[chosen] + _gathered(as_one(reduced.half.T @ as_two(y)), len(moving))
            c[chosen] = found = _minimise(reduced.S, g, None if scales is None else scales[moving])
            y = y + as_one(reduced.half @ as_two(_spread(found, len(moving))))
        v = as_one(self._factor.backward(as_two(y)))
        return c, np.where(self._free, v, 0)

    def is_ready(self, moving: Ints) -> bool:
        """Return whether the features `moving` can be placed without new columns."""
        return not moving.size or (self._reduced is not None and np.array_equal(self._reduced.moving, moving))

    def prepare(self, moving: Ints) -> "_Reduced":
        """Return the system of the features `moving`; a new one costs three substitutions forward for each."""
        if self._reduced is None or not self.is_ready(moving):
            n, k = self._count, len(moving)
            chosen = np.concatenate([moving, n + moving])
            fields = self._B[:, np.concatenate([chosen, 2 * n + moving])]
            nodes = np.unique(fields.indices).astype(np.int64)
            nodes = nodes[self._free[nodes]]
            load = np.zeros(fields.shape)
            load[nodes] = fields[nodes].toarray()
            half = self._factor.forward(load, nodes)
            U = _spread(np.eye(2 * k, dtype=np.complex128), k)
            S = self._G[np.ix_(chosen, chosen)] - U.conj().T @ (half.T @ half) @ U
            self._reduced = _Reduced(moving, half, (S + S.conj().T) / 2)
        return self._reduced


@dataclass(frozen=True)
class _Reduced:
    """The system of the features that find their own place, given the others."""

    moving: Ints
    half: Floats
    """L⁻¹ P B' (N, 3 k)."""
    S: Complexes
    """G - B* K_ff⁻¹ B (2 k, 2 k)."""


def _minimise(S: Complexes, g: Complexes, scales: Floats | None) -> Complexes:
    """Minimise ½ c* S c - Re c* g, with |α| given or not."""
    n = len(g) // 2
    if scales is None:
        return np.linalg.solve(S, g).astype(np.complex128, copy=False)
    # Translations are eliminated; then each phase in turn has its best value in closed form.
    carry = np.linalg.solve(S[n:, n:], np.column_stack([S[n:, :n], g[n:]]))
    A = S[:n, :n] - S[:n, n:] @ carry[:, :n]
    gamma = g[:n] - S[:n, n:] @ carry[:, n]
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


def _spread(c: Complexes, count: int) -> Complexes:
    """Return U c = (α, iα, t) of c = (α, t), by rows."""
    return np.concatenate([c[:count], 1j * c[:count], c[count:]])


def _gathered(p: Complexes, count: int) -> Complexes:
    """Return U* p for p (3 count,)."""
    return np.concatenate([p[:count] - 1j * p[count : 2 * count], p[2 * count :]])


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
    phi: Complexes
    """Φ for α."""
    phi_t: Floats
    """Φ for t."""
    halo: Complexes
    """H for α."""
    load: Complexes
    """B for α."""
    load_t: Floats
    """B for t."""
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
    turned, shifted = np.zeros(number.shape, np.complex128), np.zeros(number.shape)
    turned.ravel()[place], shifted.ravel()[place] = body.arms, 1
    near = (weights[0][top:bottom, left : right - 1], weights[1][top : bottom - 1, left:right])
    quads = np.s_[top : bottom - 1, left : right - 1]
    halo_weights = edge_weights(np.where(own[quads], follow[quads], 0.0))
    across, down = np.diff(rest[window], axis=1), np.diff(rest[window], axis=0)
    halo = divergence(halo_weights[0] * across, halo_weights[1] * down)
    return _Field(
        number.ravel(),
        turned.ravel(),
        shifted.ravel(),
        halo.ravel(),
        (halo - laplacian(near, turned)).ravel(),
        -laplacian(near, shifted).ravel(),
        float((halo_weights[0] * np.abs(across) ** 2).sum() + (halo_weights[1] * np.abs(down) ** 2).sum()),
    )


def _columns(nodes: list[Ints], values: list[Any], size: int) -> sparse.csc_array:
    """Assemble columns (N, k) from their values on the `nodes`, which are repeated as often as it takes."""
    places = nodes * (len(values) // len(nodes))
    starts = np.concatenate([[0], np.cumsum([len(n) for n in places])])
    return sparse.csc_array((np.concatenate(values), np.concatenate(places), starts), shape=(size, len(values)))
