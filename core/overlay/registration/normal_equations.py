"""The normal equations of the registration: their pattern, their filling from pixels by cells, their solution.

The weights of a cell's pixels are the same in every cell, so a cell's part of the equations is the matrix Σ w g gᵀ of
its pixels, g = (∂r/∂m, ∂r/∂ρ) as in `registration`, times constant products of weights.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints, Singles
from core.linalg.factor import Entries, Factor
from core.overlay.mesh import ClothMesh

PAIRS = [(a, b) for a in range(4) for b in range(a, 4)]
SYMMETRIC = [(i, j) for i in range(3) for j in range(i, 3)]
LOCAL = [(i, a) for i in range(3) for a in range(4)]
"""Unknowns of a cell: the i-th of the corner a."""
HALF = [(p, q) for n, p in enumerate(LOCAL) for q in LOCAL[n:]]
"""Pairs of them, each once: a cell's matrix is symmetric."""
_DAMPING = 64 * float(np.finfo(np.float32).eps)
"""Share of itself by which each unknown's own entry is raised: what it is a sum of is rounded to single precision."""


@dataclass(frozen=True)
class Smoothness:
    """Weights of the second differences, λ² and λ² λp of NRT eqs. 6 and 8, over the usual weight of a node's data."""

    geometry: float = 0.3
    shading: float = 1.0
    by_mean: bool = False
    """Whether the mean is the usual weight that tells geometry, not the median: on small cells between motifs most
    nodes see plain ground, which tells nothing."""

    def times(self, factor: float) -> "Smoothness":
        """Return weights so many times as large."""
        return replace(self, geometry=factor * self.geometry, shading=factor * self.shading)


USUAL = Smoothness()
"""On cells of about a quarter of a lattice step."""


class System:
    """The normal equations' pattern for a set of cells: built once, filled and solved for every step.

    Unknown are the values at those nodes of the cells that are `free` (R, C); the others hold them.
    """

    def __init__(self, mesh: ClothMesh, cells: Bools, free: Bools) -> None:
        used = mesh.nodes_of(cells)
        self.around: Ints = np.flatnonzero(used)
        self.free: Bools = free.ravel()[self.around]
        self.nodes: Ints = self.around[self.free]
        self.count = len(self.nodes)
        number = np.full(used.size, -1)
        number[self.nodes] = np.arange(self.count)
        self.corners: Ints = number[mesh.corners[cells]]
        L = mesh.bending(used)[:, self.around]
        self._bend = scipy.sparse.csr_array(L[:, self.free].T @ L)
        bend = scipy.sparse.coo_array(scipy.sparse.tril(self._bend[:, self.free]))
        self._bend_values = bend.data
        self._products = np.stack([mesh.weights[:, a] * mesh.weights[:, b] for a, b in PAIRS], -1).astype(np.float32)
        self._weights = mesh.weights.astype(np.float32)
        self._order = (
            [SYMMETRIC.index((i, j)) for (i, _), (j, _) in HALF],
            [PAIRS.index((min(a, b), max(a, b))) for (_, a), (_, b) in HALF],
        )
        self._lay_out(bend)
        self._factor: Factor | None = None

    def _lay_out(self, bend: "scipy.sparse.coo_array") -> None:
        """Find the place of every entry in the lower triangle."""
        n = self.count
        ends = [[self.corners[:, a] + i * n for i, a in pair] for pair in HALF]
        held = self.corners < 0
        self._kept = np.flatnonzero(np.concatenate([~held[:, a] & ~held[:, b] for (_, a), (_, b) in HALF]))
        first, second = (np.concatenate([pair[k] for pair in ends])[self._kept] for k in (0, 1))
        rows = np.concatenate([np.maximum(first, second)] + [bend.row + k * n for k in range(3)])
        columns = np.concatenate([np.minimum(first, second)] + [bend.col + k * n for k in range(3)])
        # The places of each pair are in order, mostly, so that a sort by merging has little to do.
        places = columns * (3 * n) + rows
        order = places.argsort(kind="stable")
        ascending = places[order]
        first = np.diff(ascending, prepend=-1) > 0
        unique, self._slot = ascending[first], np.empty(len(places), np.int64)
        self._slot[order] = np.cumsum(first) - 1
        self._pattern = (unique % (3 * n), unique // (3 * n))
        self._diagonal = np.flatnonzero(self._pattern[0] == self._pattern[1])

    def solve(
        self, moments: Singles, gradient: Singles, theta: Floats, smoothness: Smoothness, change: Floats
    ) -> Floats:
        """Return the change (3, n) of the unknowns, where the nodes `around` have the values `theta` (3, m).

        `moments` (6, K, cell²) are w h hᵀ and `gradient` (3, K, cell²) w h r of the pixels of the K cells, where the
        slopes are g = Cᵀ h with C (3, 3) the `change` of variables.
        """
        n = self.count
        blocks = np.swapaxes(np.tensordot(of_moments(change), moments @ self._products, 1), 1, 2)
        pull = np.tensordot(change.T.astype(np.float32), gradient @ self._weights, 1)
        bend = self._stiffness(blocks, smoothness)
        rhs = np.stack([self._gathered(p) for p in pull]) + bend[:, None] * (self._bend @ theta.T).T
        entries = np.concatenate([blocks[self._order].ravel()[self._kept], *(b * self._bend_values for b in bend)])
        values = np.bincount(self._slot, entries, len(self._pattern[0])).astype(np.float64)
        # Nodes that neither data nor bending hold stay where they are, and sums of single precision stay definite.
        values[self._diagonal] += _DAMPING * values[self._diagonal] + np.repeat(1e-6 * bend, n) + 1e-9
        if self._factor is None:
            self._factor = Factor(Entries(*self._pattern, values, 3 * n))
        else:
            self._factor.factorise(values)
        return -np.asarray(self._factor.solve(rhs.ravel()), np.float64).reshape(3, n)

    def _gathered(self, at_corners: Singles) -> Floats:
        """Return values (K, 4) at the corners of cells summed at the free nodes (n,)."""
        # The first sum is that of all nodes that are held.
        return np.asarray(np.bincount(self.corners.ravel() + 1, at_corners.ravel(), self.count + 1)[1:], np.float64)

    def _stiffness(self, blocks: Singles, smoothness: Smoothness) -> Floats:
        """Return the weights (3,) of the second differences of m_x, m_y and ρ, from the data's own (6, 10, K)."""
        own = [PAIRS.index((a, a)) for a in range(4)]
        x, y, rho = (self._gathered(blocks[SYMMETRIC.index((i, i))][own].T) for i in range(3))
        usual = float(np.mean(x + y) if smoothness.by_mean else np.median(x + y))
        geometry = smoothness.geometry * usual / 2
        return np.array([geometry, geometry, smoothness.shading * float(np.median(rho))]) + 1e-9


def of_moments(change: Floats) -> Singles:
    """Return the matrix (6, 6) that takes h hᵀ to g gᵀ, both by `SYMMETRIC`, where g = Cᵀ h, C (3, 3) the `change`."""
    whole = np.einsum("ki,lj->ijkl", change, change)
    rows = [[whole[i, j, k, l] + (k != l) * whole[i, j, l, k] for k, l in SYMMETRIC] for i, j in SYMMETRIC]
    return np.array(rows, np.float32)
