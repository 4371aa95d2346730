"""Similarities of the plane as complex numbers: p -> α (p - centre) + t."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from core.arrays import Floats, Ints
from core.grid import Features
from core.mapping.features.limits import FREE, NONE, Limits, Single
from core.mapping.jacobians import Complexes

LEAST_NODES = 2
"""A single node has no shape to keep."""


@dataclass(frozen=True, eq=False)
class Body:
    """The nodes of a feature that move as one."""

    number: int
    """The mask component."""
    nodes: Ints
    arms: Complexes
    """Rest positions from their centre."""
    limits: Limits = FREE

    @property
    def radius(self) -> float:
        """Distance of the node that is furthest from the centre."""
        return float(np.abs(self.arms).max())

    def fit(self, z: Complexes) -> tuple[complex, complex]:
        """Return the (α, t) that brings the body closest to z (N,) in the least-squares sense."""
        there = z[self.nodes]
        return complex(np.vdot(self.arms, there) / np.vdot(self.arms, self.arms)), complex(there.mean())

    def place(self, alpha: complex, t: complex) -> Complexes:
        """Return where (α, t) takes the nodes."""
        return alpha * self.arms + t


class Bodies:
    """Many bodies, k, whose nodes are placed, and similarities found, in a few operations on all."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        counts = np.array([len(body.nodes) for body in bodies], np.int64)
        self.count = len(bodies)
        self.nodes = np.concatenate([np.empty(0, np.int64), *(body.nodes for body in bodies)])
        """Of all, one body after the other."""
        self._arms = np.concatenate([np.empty(0, np.complex128), *(body.arms for body in bodies)])
        self._owner = np.repeat(np.arange(self.count), counts)
        self._starts, self._counts = np.cumsum(counts) - counts, counts
        self._spread = self._sums(np.abs(self._arms) ** 2).real
        self.turns = np.array([body.limits.turns for body in bodies], bool)
        """Which do not have to stay upright."""
        self._bounds = np.array([(body.limits.least, body.limits.most) for body in bodies]).reshape(-1, 2)

    def place(self, alpha: Complexes, t: Complexes, chosen: Ints | slice = np.s_[:]) -> Complexes:
        """Return where (α, t), (k,) each, take `nodes`, or the `chosen` ones."""
        owner = self._owner[chosen]
        return np.asarray(alpha[owner] * self._arms[chosen] + t[owner])

    def fit(self, z: Complexes) -> tuple[Complexes, Complexes]:
        """Return the (α, t), (k,) each, that bring the bodies closest to z (N,), as `Body.fit` does."""
        there = z[self.nodes]
        return self._sums(self._arms.conj() * there) / self._spread, self._sums(there) / self._counts

    @cached_property
    def fitting(self) -> "scipy.sparse.csr_array":
        """What of `nodes` makes up the same (α, t), one after the other (2 k, n)."""
        values = np.concatenate([self._arms.conj() / self._spread[self._owner], 1 / self._counts[self._owner]])
        places = np.concatenate([self._owner, self.count + self._owner]), np.tile(np.arange(len(self.nodes)), 2)
        return scipy.sparse.csr_array((values, places), (2 * self.count, len(self.nodes)))

    def fit_within(self, z: Complexes) -> tuple[Complexes, Complexes]:
        """Return the (α, t), (k,) each, that bring the bodies closest to z (N,) within their limits."""
        alpha, t = self.fit(z)
        alpha = np.where(self.turns, alpha, np.maximum(alpha.real, 0))
        size = np.abs(alpha)
        found = self.clip_sizes(size, np.arange(self.count))
        over = np.divide(size, found, out=np.ones_like(size), where=(size > 0) & (found > 0))
        return alpha / over, t

    def clip_sizes(self, sizes: Floats, chosen: Ints) -> Floats:
        """Return sizes (m,) of the `chosen` bodies (m,), the nearest within their limits."""
        return np.asarray(np.clip(sizes, *self._bounds[chosen].T), np.float64)

    def _sums(self, values: NDArray[Any]) -> Complexes:
        """Return the sum over the nodes of each body."""
        if not self.count:
            return np.empty(0, np.complex128)
        return np.asarray(np.add.reduceat(values, self._starts), np.complex128)


def bodies_of(
    features: Features, rest: Complexes, usual: Limits = FREE, single: Single = NONE, known: Iterable[Body] = ()
) -> list[Body]:
    """Return a body for every feature that has a shape, by component number; rest is (R, C).

    Those not in `single` have the `usual` limits. Those that are `known` on the same grid are the same objects.
    """
    before = {(body.number, body.limits, body.nodes.tobytes()): body for body in known}
    labels = features.labels.ravel()
    marked = np.flatnonzero(labels)
    marked = marked[np.argsort(labels[marked], kind="stable")]
    numbers, first = np.unique(labels[marked], return_index=True)
    bodies = []
    for number, nodes in zip(numbers, np.split(marked, first[1:]), strict=False):
        if len(nodes) >= LEAST_NODES:
            key = int(number), single.get(int(number), usual), nodes.tobytes()
            bodies.append(before[key] if key in before else _body(*key[:2], nodes, rest))
    return bodies


def _body(number: int, limits: Limits, nodes: Ints, rest: Complexes) -> Body:
    p = rest.ravel()[nodes]
    return Body(number, nodes, p - p.mean(), limits)


def body_index(bodies: list[Body], shape: tuple[int, int]) -> Ints:
    """Return the index into `bodies` of every node (R, C), -1 for none."""
    index = np.full(shape, -1)
    for i, body in enumerate(bodies):
        index.ravel()[body.nodes] = i
    return index


def fit_residual(rest: Complexes, moved: Complexes, *, rigid: bool) -> float:
    """Return the RMS distance from the best-fit similarity (or rigid motion) over the RMS radius of the fit."""
    p, q = rest - rest.mean(), moved - moved.mean()
    alpha = np.vdot(p, q) / np.vdot(p, p)
    if rigid and alpha:
        alpha /= abs(alpha)
    radius = np.sqrt(np.mean(np.abs(alpha * p) ** 2))
    return float(np.sqrt(np.mean(np.abs(q - alpha * p) ** 2)) / radius) if radius else float("inf")
