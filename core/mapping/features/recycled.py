"""How free nodes follow loads, and hold points, in frames that are much like those before."""

import numpy as np

from core.arrays import Floats, Ints
from core.linalg.multifrontal import GridFactor
from core.linalg.reduced_basis import ReducedBasis
from core.mapping.features.pose import HeldPoints
from core.mapping.features.reduced_system import as_one, as_two
from core.mapping.jacobians import Complexes
from core.mapping.tolerances import SEEN_PX, UNSEEN_PX

_FEW = 16
"""So many points have paid for what they take after as many frames: a quarter of a second."""


class Recycled:
    """What answers to earlier loads tell of the next one, for one factor and the same points held.

    K_ff⁻¹ has no negative entries. So a load r moves no node further than max |r / g| times as far as the load g > 0
    moves the one that it moves furthest: that tells how far what is left of a load would move any at most, in drags 2
    to 8 times what it does. What points miss is known exactly: that of a few by G = K_ff⁻¹ Cᵀ, that of many by half a
    solve, since G takes as many.
    """

    def __init__(self, factor: GridFactor, points: HeldPoints) -> None:
        self._factor, self._points = factor, points
        self._nodes = np.empty(0, np.int64)
        self._G: Floats | None = None
        """At these nodes, transposed (m', m); None for many points."""
        self._basis: ReducedBasis | None = None

    def miss(self, load: Floats, nodes: Ints, missed: Complexes) -> Complexes:
        """Return what the points miss (k,) under a load (m, 2) at `nodes`, given what they miss without."""
        if self._basis is None or nodes is not self._nodes:
            self._begin(nodes, len(missed))
        if self._G is None:
            return missed - self._points.moved_by(self._factor.forward_again(load, nodes))
        return np.asarray(missed - self._points.M @ as_one(self._G @ load))

    def answer(self, load: Floats, missed: Complexes) -> Complexes:
        """Return how far all nodes (N,) move under the last load, with points held that miss so much under it."""
        assert self._basis is not None
        return self._basis.answer(np.concatenate([as_one(load), missed]))

    @property
    def is_new(self) -> bool:
        """Whether the last load had anything that those before it had not."""
        return self._basis is not None and self._basis.is_new

    def learn(self) -> None:
        """Let the next answers be nearer to the exact ones."""
        if self._basis is not None:
            self._basis.learn()

    def _begin(self, nodes: Ints, points: int) -> None:
        g = np.zeros((self._factor.size, 1))
        g[nodes, 0] = self._factor.diagonal[nodes]
        furthest = self._factor.solve(g).max(initial=1)
        self._nodes, count = nodes, len(self._points.nodes)
        self._G = None if count > _FEW else self._factor.backward(self._points.half @ np.eye(count))[nodes].T.copy()
        self._basis = ReducedBasis(
            self._evaluate, np.append(SEEN_PX / 2 / furthest * g[nodes], np.full(points, UNSEEN_PX))
        )

    def _evaluate(self, x: Complexes) -> Complexes:
        load, missed = np.split(x, [len(self._nodes)])
        y = self._factor.forward_again(as_two(load), self._nodes)
        return as_one(self._factor.backward(y + self._points.pull(missed)))
