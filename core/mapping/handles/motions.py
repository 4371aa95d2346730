"""How the plate's points move with bodies that it knows by points of their rims, and which motions are unknown.

A body that goes from (α⁰, t⁰) to (α, t) moves a point with the arm p by (α - α⁰) p + t - t⁰. So bodies move the points
by B c, B with two columns, p and 1, for each body, and c = (α - α⁰, t - t⁰). Unknown motions of bodies are real: a turn
φ about the arm q changes (α, t) by iα (1, -q) φ, moves along x and y change it by (0, 1) and (0, i).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints
from core.mapping.jacobians import Complexes


@dataclass(frozen=True, eq=False)
class Poses:
    """Similarities of all bodies."""

    alpha: Complexes
    t: Complexes
    pivots: Complexes
    """Where the points are that bodies turn about which are held at one place, NaN for others."""


@dataclass(frozen=True, eq=False)
class Motions:
    """The bodies that have points of the plate, k, and what is unknown of how they move."""

    bodies: Ints
    points: "scipy.sparse.csr_array"
    """B (n, 2 k): arms, then ones."""
    about: Complexes
    """The arm that each turns about (k,), 0 for those that no handle holds."""
    turning: Ints
    """Which of them turn (m,), as costs least,"""
    moving: Ints
    """and which move (l,)."""

    @classmethod
    def of(
        cls, bodies: list[int], arms: list[Complexes], first: int, about: Complexes, turns: Bools, moves: Bools
    ) -> "Motions":
        """Return those of `bodies` with points at `arms`, which are the plate's from number `first` on."""
        k, counts = len(bodies), [len(part) for part in arms]
        owner = np.repeat(np.arange(k), counts)
        rows = first + np.arange(len(owner))
        values = np.concatenate([np.empty(0, np.complex128), *arms, np.ones(len(owner))])
        places = np.tile(rows, 2), np.concatenate([owner, k + owner])
        points = scipy.sparse.csr_array((values, places), (first + len(owner), 2 * k))
        return cls(np.array(bodies, np.int64), points, about, np.flatnonzero(turns), np.flatnonzero(moves))

    def displace(self, poses: Poses, alpha: Complexes, t: Complexes) -> Complexes:
        """Return by how much bodies at `poses` have moved the points (n,) from where (`alpha`, `t`) have them."""
        changes = (poses.alpha - alpha)[self.bodies], (poses.t - t)[self.bodies]
        return np.asarray(self.points @ np.concatenate(changes), np.complex128)

    @cached_property
    def unknown(self) -> "scipy.sparse.csr_array":
        """How the points move (n, m + 2 l) by what is unknown, each up to a factor (`directions`)."""
        k, m, l = len(self.bodies), len(self.turning), len(self.moving)
        moved = np.tile(k + self.moving, 2)
        rows = np.concatenate([self.turning, k + self.turning, moved])
        columns = np.concatenate([np.arange(m), np.arange(m), np.arange(m, m + 2 * l)])
        values = np.concatenate([np.ones(m), -self.about[self.turning], np.ones(2 * l)])
        return scipy.sparse.csr_array(
            self.points @ scipy.sparse.csr_array((values, (rows, columns)), (2 * k, m + 2 * l))
        )

    def directions(self, alpha: Complexes) -> Complexes:
        """Return the factors (m + 2 l,) where all bodies are turned by `alpha`: iα of those that turn, 1, and i."""
        turned = 1j * alpha[self.bodies[self.turning]]
        return np.concatenate([turned, np.ones(len(self.moving)), np.full(len(self.moving), 1j)])

    def move(self, poses: Poses, motions: Floats) -> None:
        """Turn and move bodies by their unknown `motions` (m + 2 l,); their sizes stay."""
        m, l = len(self.turning), len(self.moving)
        turns, x, y = motions[:m], motions[m : m + l], motions[m + l :]
        poses.alpha[self.bodies[self.turning]] *= np.exp(1j * turns)
        poses.t[self.bodies[self.moving]] += x + 1j * y
        held = np.flatnonzero(np.isfinite(poses.pivots[self.bodies]))
        bodies = self.bodies[held]
        poses.t[bodies] = poses.pivots[bodies] - poses.alpha[bodies] * self.about[held]
