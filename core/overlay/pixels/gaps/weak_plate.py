"""A plate through places of the cloth that are known, pixel by pixel, which tears where it would be strained too much.

Unknown is the place m = S uv in the undeformed cloth at every free pixel. Minimised is the sum of the squared second
differences of m, and of what the strain s of each step between two pixels costs, its difference from the slopes of the
cloth around:

    Σ |∂²m|² + h Σ t s² / (t + s²).

A small strain costs its square, any large one no more than t: the two sides of a gap that miss each other by much over
a short way meet in one jump, and the jump runs where that is shortest. The second differences across it do not count.
It is found by reweighting, from a t so large that nothing tears down to the one wanted (Geman and McClure; Blake and
Zisserman's graduated non-convexity).
"""

import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints
from core.linalg.factor import Factor
from core.overlay.filters.distances import within

FIRST, ROUNDS, LAST = 8.0, 8, 3
"""The first t over the wanted one, as its root, the steps down to that, and how many more are taken there."""
HELD = 0.3
"""h."""
BESIDE_PX = 3.5
"""Distance up to which what is fixed holds what is free."""
LEAST = 1e-6
"""Weight of what is torn, so that everything hangs together."""


class Plate:
    """The least strained places at `free` pixels (H, W) amid `fixed` ones.

    `places` (H, W, 2) are m where it is fixed; `slopes` (H, W, 2, 2), by row and column, are those without strain.
    """

    def __init__(self, places: Floats, fixed: Bools, free: Bools, slopes: Floats) -> None:
        self._free: Ints = np.flatnonzero(free)
        self._known = np.where(fixed[..., None], places, 0.0).reshape(-1, 2)
        used = (free | (fixed & within(free, BESIDE_PX))).ravel()
        number = np.arange(used.size).reshape(fixed.shape)
        ends: list[Ints] = []
        wanted: list[Floats] = []
        at: list[Ints] = []
        for axis in (0, 1):
            here, there = (np.moveaxis(number, axis, 0)[part].ravel() for part in (np.s_[:-1], np.s_[1:]))
            both = used[here] & used[there]
            here, there = here[both], there[both]
            at.append(np.full(used.size, -1))
            at[-1][here] = np.arange(len(here)) + (len(ends[0]) if ends else 0)
            ends.append(np.stack([here, there], -1))
            side = slopes[..., axis].reshape(-1, 2)
            wanted.append((side[here] + side[there]) / 2)
        # The pixels, by number, between which each step leads.
        between = np.concatenate(ends)
        self._wanted = np.concatenate(wanted)
        self._steps = differences(between, np.ones(len(between)), used.size)
        pairs, weights, around = bends(at[0].reshape(fixed.shape), at[1].reshape(fixed.shape))
        bending = scipy.sparse.csr_array(differences(pairs, weights, len(between)) @ self._steps)
        moves = abs(bending) @ free.ravel().astype(np.float64) > 0
        self._around = around[moves]
        self._moving: Bools = np.asarray(free.ravel()[between].any(1), np.bool_)
        rows = scipy.sparse.csr_array(
            scipy.sparse.vstack([bending[np.flatnonzero(moves)], self._steps[np.flatnonzero(self._moving)]])
        )
        wished = self._wanted[self._moving]
        self._right = np.concatenate([np.zeros((int(moves.sum()), 2)), wished]) - rows @ self._known
        self._rows = scipy.sparse.csr_array(rows[:, self._free])
        self._factor: Factor | None = None

    def weakened(self, most: float) -> Floats:
        """Return the places (n, 2) of the free pixels; t is `most`."""
        weight = np.ones(len(self._wanted))
        for number in range(ROUNDS + LAST):
            m = self._solved(weight)
            strain = np.linalg.norm(self._steps @ m - self._wanted, axis=-1)
            t = most * FIRST ** (2 * max(0.0, 1 - number / ROUNDS))
            weight = np.maximum(1 / (1 + strain**2 / t) ** 2, LEAST)
        return np.asarray(m[self._free], np.float64)

    def _solved(self, weight: Floats) -> Floats:
        """Return the places (H W, 2) for weights (m,) of the steps."""
        given = np.concatenate([weight[self._around].min(1), HELD * weight[self._moving]])
        weighted = scipy.sparse.csr_array(self._rows.T.multiply(given))
        normal = scipy.sparse.csc_array(weighted @ self._rows + 1e-9 * scipy.sparse.eye_array(len(self._free)))
        normal.sort_indices()
        lower = scipy.sparse.csc_array(scipy.sparse.tril(normal, format="csc"))
        if self._factor is not None and np.array_equal(self._factor.indices, lower.indices):
            self._factor.factorise(lower.data)
        else:
            self._factor = Factor(normal)
        out = self._known.copy()
        out[self._free] = self._factor.solve(weighted @ self._right)
        return out


def differences(pairs: Ints, weights: Floats, size: int) -> "scipy.sparse.csr_array":
    """Return the matrix (n, size) of the weighted differences between the values of pairs (n, 2)."""
    count = len(pairs)
    values = (weights[:, None] * [-1.0, 1.0]).ravel()
    return scipy.sparse.csr_array((values, (np.repeat(np.arange(count), 2), pairs.ravel())), shape=(count, size))


def bends(down: Ints, across: Ints) -> tuple[Ints, Floats, Ints]:
    """Return pairs (n, 2) of steps whose differences are the second ones, weights (n,) and the steps around (n, 4).

    `down` and `across` (H, W) are the number of the step from each pixel, -1 where there is none.
    """
    straight = [
        np.stack([steps[here].ravel(), steps[there].ravel()], -1)
        for steps, here, there in ((down, np.s_[:-1], np.s_[1:]), (across, np.s_[:, :-1], np.s_[:, 1:]))
    ]
    pairs = np.concatenate(straight)
    pairs = pairs[(pairs >= 0).all(1)]
    twist = np.stack([across[:-1, :-1], across[1:, :-1], down[:-1, :-1], down[:-1, 1:]], -1).reshape(-1, 4)
    twist = twist[(twist >= 0).all(1)]
    weights = np.concatenate([np.ones(len(pairs)), np.full(len(twist), np.sqrt(2))])
    return np.concatenate([pairs, twist[:, :2]]), weights, np.concatenate([np.tile(pairs, 2), twist])
