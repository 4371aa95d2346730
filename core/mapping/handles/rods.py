"""Straight lines of the picture as rods in the plate that handles bend: what keeps them straight as they move.

A line has samples, closer towards its ends, C d their displacements, √ℓ M an orthonormal basis of all √ℓ d that are
neither constant nor linear along the line, ℓ the cells of it that a sample stands for, and n the normal of the line
where it lies. Where the rest of the displacement leaves bends
b = Re n̄ M C (z⁰ + y) - Re n̄⁰ M C z⁰, those of now beyond those that the line has without handles, the energy of
`plate` gains w_F² / 2 |b + Re n̄ M C (d - y)|², w_F the weight of features, by which the equations of these are
multiplied, too; samples that glide along the line add nothing. It pushes by forces n f, one real f
for each row of M. Points that handles hold have the forces λ,

    λ = S⁻¹ (g + X m - B n f),      s f + Re n̄ (B* λ + V m + S_ll n f) = -b,      s = 2 / w_F²,

with g what is known of them, B and S_ll what rows do to points and to rows, and m all that is unknown beside forces:
motions c of bodies, X = Q, and how far q places of a straight frame slide along their sides where lines end there. Each
takes the picture along by a harmonic field Y, X = -C Y and V = M C Y, at the cost σ q² of the membrane. So with
H = Re n̄ (B* S⁻¹ X + V), F = (s + Re n̄ (S_ll - B* S⁻¹ B) n)⁻¹ and β = b + Re n̄ B* S⁻¹ g,

    (Re X* S⁻¹ X + σ + Hᵀ F H) m = -(Re X* S⁻¹ g + Hᵀ F β),      f = -F (β + H m).

Handles and bodies are met exactly; lines are as straight as these leave them.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from core.arrays import Floats, Ints, Points
from core.grid import Grid
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.limits import Limits
from core.mapping.features.line_rows import along_lines, bends_of, fixed_directions
from core.mapping.features.straight_lines import Lines, slides_of
from core.mapping.jacobians import Complexes
from core.mapping.tolerances import ROUNDING

_STEP, _FEWEST = 0.04, 3
"""Distance of samples, as a share of the picture's diagonal: the plate is smooth over several; the fewest of a line."""
_NEAR_ENDS = (0.5,)
"""Further samples so many steps from both ends: where these are on a frame that is held, the plate is stiff."""
_MOST_ROWS = 192
"""Rows of M: the shortest lines are left out beyond, so that a frame's system stays small."""


@dataclass(frozen=True, eq=False)
class Rods:
    """Samples of lines."""

    at: Points
    """(m, 2), pixels of the picture."""
    M: "scipy.sparse.csr_array"
    """(k, m)."""
    owner: Ints
    """The line of each row (k,)."""
    softness: Floats
    """s of each row (k,)."""
    first: Ints
    last: Ints
    """The samples at the ends of each line."""
    ends: Points
    """Of the lines (n, 2, 2)."""
    fixed: Complexes
    """The directions (n,) of those that stay upright, 0 for the others."""

    @classmethod
    def none(cls, grid: Grid) -> "Rods":
        """Return that there are none."""
        return cls.of(grid, Lines(np.empty((0, 2, 2))), 1.0)

    def __len__(self) -> int:
        """Return how many rows M has."""
        return len(self.softness)

    @classmethod
    def of(cls, grid: Grid, lines: Lines, weight: float) -> "Rods":
        """Return those of lines; one that is protected by p has the weight of such a feature, w_F to the power p."""
        ends = lines.ends
        step = _STEP * float(np.hypot(grid.width_px, grid.height_px))
        lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        shares = [_sample(max(round(length / step), _FEWEST)) for length in lengths.tolist()]
        rows = np.array([len(share) - 1 - lim.turns for share, lim in zip(shares, lines.limits_of_each, strict=True)])
        limits = lines.limits_of_each[: int((np.cumsum(rows) <= _MOST_ROWS).sum())]
        shares, rows, ends = shares[: len(limits)], rows[: len(limits)].astype(np.int64), ends[: len(limits)]
        cells = (lengths / np.sqrt(grid.cell[0] * grid.cell[1])).tolist()
        at = [a + (b - a) * share[:, None] for (a, b), share in zip(ends, shares, strict=True)]
        bases = [_weigh(share, length, limit) for share, length, limit in zip(shares, cells, limits, strict=False)]
        owner, counts = np.repeat(np.arange(len(rows)), rows), np.array([len(share) for share in shares], np.int64)
        return cls(
            np.concatenate([np.empty((0, 2)), *at]),
            scipy.sparse.csr_array(scipy.sparse.block_diag(bases)) if bases else scipy.sparse.csr_array((0, 0)),
            owner,
            2 / weight ** (2 * np.array([limit.weight for limit in limits])[owner]),
            np.cumsum(counts) - counts,
            np.cumsum(counts) - 1,
            ends,
            fixed_directions(ends, limits),
        )

    def read(self, grid: Grid, z: Complexes) -> Complexes:
        """Return what z (N,) or (N, q) at the nodes is at the samples."""
        return grid.read(self.at, z)

    def normals(self, there: Complexes) -> Complexes:
        """Return the normal of the line of each row (k,) with samples `there` (m,)."""
        return 1j * along_lines(there[self.last] - there[self.first], self.fixed)[self.owner]

    def bends(self, there: Complexes, normals: Complexes) -> Floats:
        """Return Re n̄ M C z (k,) for samples `there` (m,)."""
        return np.asarray((np.conj(normals) * (self.M @ there)).real)


def _sample(steps: int) -> Floats:
    """Return where the samples of a line with so many steps lie, 0 to 1."""
    near = np.array(_NEAR_ENDS) / steps
    return np.sort(np.concatenate([np.linspace(0, 1, steps + 1), near, 1 - near]))


def _weigh(share: Floats, cells: float, limits: Limits) -> Floats:
    """Return M (k, s) of a line so many `cells` long with samples at `share` (s,) of it."""
    middles = np.concatenate([[0.0], (share[1:] + share[:-1]) / 2, [1.0]])
    root = np.sqrt(cells * np.diff(middles))[:, None]
    return bends_of(root, root * share[:, None], limits) * root.T


@dataclass(frozen=True, eq=False)
class Slides:
    """How places of a straight frame slide along their sides, and what follows them."""

    fields: Complexes
    """Y (N, q)."""
    cost: Floats
    """σ (q, q)."""
    at_points: Complexes
    at_rows: Complexes
    """C Y (n, q) and M C Y (k, q)."""

    def where(self, slides: bool) -> "Slides":
        """Return these, or that the frame stays."""
        if slides:
            return self
        return Slides(self.fields[:, :0], self.cost[:0, :0], self.at_points[:, :0], self.at_rows[:, :0])


def slides_with(rods: Rods, mapping: FeatureMapping, stay: Points) -> list[tuple[complex, Floats]]:
    """Return along what, and by which shapes (R, C), a held frame slides with rods, but not points that `stay` (n, 2).

    They are flat where lines end: from a kink of the frame the field that follows it falls off at once.
    """
    grid, index = mapping.grid, mapping.index.copy()
    nodes, weights = grid.weights_at(stay)
    index.ravel()[nodes[weights > ROUNDING]] = 0
    return [(along, u**2 * (3 - 2 * u)) for along, u in slides_of(grid, index, rods.ends.reshape(-1, 2))]


@dataclass(frozen=True, eq=False)
class Found:
    """What answers handles, beside the forces on their points."""

    motions: Floats
    """c (u,)."""
    slid: Floats
    """q."""
    forces: Complexes
    """n f (k,)."""


class RodSystem:
    """The system of rods for one set of points.

    Parameters
    ----------
    inverse
        S⁻¹ (n', n') of the points, with further unknowns of the plate behind them.
    across
        B (n', k).
    within
        S_ll (k, k).
    """

    def __init__(self, rods: Rods, inverse: NDArray[Any], across: NDArray[Any], within: NDArray[Any]) -> None:
        self._rods, self._inverse, self.across = rods, inverse, across
        self._carry = across.conj().T @ inverse
        self._within = within - self._carry @ across
        self._last: tuple[Complexes, Floats] | None = None
        """The normals that were taken last, and F⁻¹ for them."""

    def find(self, known: Complexes, Q: Complexes, slides: Slides, normals: Complexes, bends: Floats) -> Found:
        """Return the motions c of bodies, q of the frame, and forces for what is `known` of points (n,)."""
        n, u = Q.shape
        inverse, carry = self._inverse[:n, :n], self._carry[:, :n]
        X = np.hstack([Q, -slides.at_points])
        V = np.hstack([np.zeros((len(bends), u)), slides.at_rows])
        across = X.conj().T @ inverse
        N = (across @ X).real
        N[u:, u:] += slides.cost
        H = (np.conj(normals)[:, None] * (carry @ X + V)).real
        beta = bends + (np.conj(normals) * (carry @ known)).real
        solved = scipy.linalg.cho_solve(self._factor(normals), np.column_stack([H, beta]), check_finite=False)
        given = (across @ known).real + H.T @ solved[:, -1]
        m = np.linalg.lstsq(N + H.T @ solved[:, :-1], -given, rcond=1e-12)[0]
        return Found(m[:u], m[u:], -normals * (solved[:, -1] + solved[:, :-1] @ m))

    def _factor(self, normals: Complexes) -> tuple[Floats, bool]:
        """Return F⁻¹, factored."""
        if self._last is None or not np.array_equal(self._last[0], normals):
            system = (np.conj(normals)[:, None] * self._within * normals).real
            system[np.diag_indices_from(system)] += self._rods.softness
            self._last = normals, scipy.linalg.cholesky(system, lower=True, check_finite=False)
        return self._last[1], True
