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

from core.arrays import Bools, Floats, Ints
from core.linalg.grid_solver import GridSolver, HalfSolved
from core.mapping.features.columns import Field, pairs_that_meet
from core.mapping.features.pose import Start
from core.mapping.jacobians import Complexes
from core.mapping.tolerances import TIE

_ROUNDS = 50


class ReducedSystem:
    """The reduced system of (α, t) over a factorised grid.

    Parameters
    ----------
    fields
        Of the features to place.
    free
        Nodes (R, C) that are neither on the outline nor in a feature.
    factor
        Of K_ff, with the equation x = 0 on all other nodes.
    """

    def __init__(self, fields: list[Field], *, free: Bools, factor: GridSolver) -> None:
        self.fields = fields
        self._factor, self._free = factor, free
        self._count = n = len(fields)
        self._G = np.zeros((2 * n, 2 * n), np.complex128)
        for i, field in enumerate(fields):
            self._G[i::n, i::n] = field.with_itself
        for i, j in pairs_that_meet(fields):
            self._G[i::n, j::n] = fields[i].with_other(fields[j], TIE)
        self._reduced: _Reduced | None = None

    def find(
        self,
        start: Start,
        load: Floats,
        nodes: Ints,
        scales: Floats | None,
        *,
        given: Complexes,
        moving: Ints,
        turns: Bools,
    ) -> tuple[Complexes, Any]:
        """Return c = (α, t) and the load of v without the columns of the features `moving`, for a start z⁰.

        `load` (m, 2) is r + B c, c of the features that do not move, at these free `nodes`, 0 elsewhere. The features
        `moving` find their place, with |α| = `scales`, one for each, where these are given, and α real where one of
        them does not turn (`turns`); the others have that of `given`, (α, t), which is 0 of those that move.
        """
        y = self._factor.forward_again(load, nodes)
        c = given.copy()
        if moving.size:
            reduced = self.prepare(moving)
            chosen = np.concatenate([moving, self._count + moving])
            g = np.array([self.fields[i].weighed(start) for i in moving]).T.ravel() - (self._G @ c)[chosen]
            g += _gather(as_one(reduced.half.T @ y), len(moving))
            c[chosen] = _minimise(reduced.S, g, scales, turns)
        return c, y

    def load_of(self, c: Complexes, y: Any, moving: Ints) -> Any:
        """Return the load of v for the features `moving` at c = (α, t), and the load that `find` gave."""
        if not moving.size:
            return y
        chosen = np.concatenate([moving, self._count + moving])
        return y + self.prepare(moving).half @ as_two(spread(c[chosen]))

    def is_ready(self, moving: Ints) -> bool:
        """Return whether the features `moving` can be placed without new columns."""
        return not moving.size or (self._reduced is not None and np.array_equal(self._reduced.moving, moving))

    def prepare(self, moving: Ints, asked: Ints | None = None) -> "_Reduced":
        """Return the system of the features `moving`; a new one costs three substitutions forward for each.

        Loads will be at the nodes that are `asked`.
        """
        if self._reduced is None or not self.is_ready(moving):
            k, free = len(moving), self._free.ravel()
            load = np.zeros((free.size, 3 * k))
            fields = [self.fields[i] for i in moving]
            for place, field in enumerate(fields):
                there = free[field.border]
                load[field.border[there], place::k] = field.columns[there]
            half = self._factor.forward(load, np.concatenate([field.border for field in fields]), asked)
            chosen = np.concatenate([moving, self._count + moving])
            U = spread(np.eye(2 * k, dtype=np.complex128))
            S = self._G[np.ix_(chosen, chosen)] - U.conj().T @ (half.T @ half) @ U
            self._reduced = _Reduced(moving, half, (S + S.conj().T) / 2)
        return self._reduced


@dataclass(frozen=True)
class _Reduced:
    """The system of the features that find their own place, given the others."""

    moving: Ints
    half: HalfSolved
    """L⁻¹ P B' (N, 3 k)."""
    S: Complexes
    """G - B* K_ff⁻¹ B (2 k, 2 k)."""


def _minimise(S: Complexes, g: Complexes, scales: Floats | None, turns: Bools) -> Complexes:
    """Minimise ½ c* S c - Re c* g, with |α| given or not; where it is, α = |α| but for those that turn."""
    n = len(g) // 2
    if scales is None:
        return np.linalg.solve(S, g).astype(np.complex128, copy=False)
    # Translations are eliminated; then each phase in turn has its best value in closed form.
    carry = np.linalg.solve(S[n:, n:], np.column_stack([S[n:, :n], g[n:]]))
    A = S[:n, :n] - S[:n, n:] @ carry[:, :n]
    gamma = g[:n] - S[:n, n:] @ carry[:, n]
    alpha = np.where(turns, _with_length(np.linalg.solve(A, gamma), scales), scales)
    for _ in range(_ROUNDS):
        before = alpha.copy()
        for j in np.flatnonzero(turns):
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


def spread(c: Complexes) -> Complexes:
    """Return U c = (α, iα, t) of c = (α, t), by rows."""
    count = len(c) // 2
    return np.concatenate([c[:count], 1j * c[:count], c[count:]])


def _gather(p: Complexes, count: int) -> Complexes:
    """Return U* p for p (3 count,)."""
    return np.concatenate([p[:count] - 1j * p[count : 2 * count], p[2 * count :]])


def as_two(z: Complexes) -> NDArray[np.float64]:
    """Return x + iy (N,) as two columns (N, 2)."""
    return z[:, None].view(np.float64)


def as_one(columns: NDArray[np.float64]) -> Complexes:
    """Return two columns (N, 2) as x + iy (N,)."""
    return np.ascontiguousarray(columns).view(np.complex128)[:, 0]
