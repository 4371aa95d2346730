"""Lines of the picture that are to stay straight: a soft term of the energy, for features where they are.

A line has samples at equal steps, each a mean over the line to the next ones. C z is where they are, read bilinearly;
M, an orthonormal basis of all that is neither constant nor linear along the line, takes that to what no straight line
explains. With n the normal of the line where it lies, Re n̄ (M C z) is what bends it: samples that glide along the line
add nothing. Of a level or plumb line, a horizon, what is linear along it counts likewise, with n the normal of the
line where W alone takes it: it keeps its tilt. Added to the energy is

    ½ w_F ℓ Σ |Re n̄ (M C z)|²,

w_F the weight of features and ℓ the cells of the line that a sample stands for. It draws at the free nodes by forces f,
one for each row of M, which follow from the bends b without them by a small system [Woodbury's formula]:

    (Re n̄ n' P + 1 / (w_F ℓ)) f = -b,      P = M C K_ff⁻¹ Cᵀ Mᵀ.

So the factor of the grid stays as it is. What single lines may do is said by limits (`line_rows`).

Where the frame may glide, it does so with lines that end on it: each end has an unknown move q along its side, which
fades to the next one, or to the corner. With U what it moves of the frame, d its direction, F = M (C U - C K_ff⁻¹ K U)
what that does to the rows, S = Uᵀ K U - (K U)ᵀ K_ff⁻¹ (K U) what it costs, and G = Re n̄ d F, the system gains
G S⁻¹ Gᵀ, and q = S⁻¹ Gᵀ f.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from core.arrays import Floats, Ints, Points
from core.grid import Grid
from core.linalg.blas import one_thread
from core.linalg.grid_solver import HalfSolved
from core.linalg.laplacian import edge_weights, laplacian
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.limits import FREE, Limits
from core.mapping.features.line_rows import LineRows, along_lines, are_level, bends_of, fixed_directions
from core.mapping.features.pose import HeldPoints, Solution
from core.mapping.features.reduced_system import as_one, as_two
from core.mapping.jacobians import Complexes

_STEP, _FEWEST = 0.02, 4
"""Distance of samples, as a share of the picture's diagonal; so many has the shortest line."""
_MOST_NUMBERS = 16_000_000
"""Numbers in the responses of all samples: what does not fit, the shortest lines, is left out."""
_ON_FRAME, _APART = 0.5, 2
"""Cells from the frame within which a line ends on it, and between places that move by themselves."""
_ROUNDS = 3
"""Times that the normals are taken, each from where the lines then lie."""


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight lines of a picture by their ends (n, 2, 2), in pixels, the longest first; alike where these are."""

    ends: Points
    limits: tuple[Limits, ...] = ()
    """What each may do; none where all are free to turn and stretch."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Lines) and np.array_equal(self.ends, other.ends) and self.limits == other.limits

    def __hash__(self) -> int:
        return hash(self.ends.tobytes())

    @property
    def limits_of_each(self) -> tuple[Limits, ...]:
        """The limits (n)."""
        return self.limits or (FREE,) * len(self.ends)


@dataclass(frozen=True, eq=False)
class Pull:
    """What draws an answer elsewhere: a load at the nodes, and how far the frame glides, (R, C) each."""

    load: Complexes
    glide: Complexes

    def apply(self, mapping: FeatureMapping, found: Solution) -> Solution:
        """Return the answer under it, with features where they are: a solve."""
        glide = np.where(mapping.index < 0, self.glide, 0)
        load = self.load - laplacian(edge_weights(mapping.follow_w + mapping.follow_feature), glide)
        with one_thread():
            moved = as_one(mapping.factor.solve(as_two(np.where(mapping.free, load, 0).ravel())))
        return Solution(found.z + glide + moved.reshape(glide.shape), found.alpha, found.t)


class LineSolver:
    """Straightens lines by the factor of one mapping; prepared once for it, a solve for each answer."""

    def __init__(self, mapping: FeatureMapping, lines: Lines, weight: float) -> None:
        self._mapping, grid = mapping, mapping.grid
        step = _STEP * float(np.hypot(grid.width_px, grid.height_px))
        lengths = np.linalg.norm(lines.ends[:, 1] - lines.ends[:, 0], axis=1)
        counts = np.maximum(np.rint(lengths / step).astype(np.int64) + 1, _FEWEST)
        counts = counts[np.cumsum(counts) * grid.size <= _MOST_NUMBERS]
        self.count = len(counts)
        """Of the lines."""
        if not self.count:
            return
        samples = [_sample(count, round(2 * step / min(grid.cell))) for count in counts]
        at = np.concatenate([a + (b - a) * u[..., None] for (a, b), (u, _) in zip(lines.ends, samples, strict=False)])
        means = [(u * share).sum(axis=1, keepdims=True) for u, share in samples]
        limits = lines.limits_of_each[: self.count]
        bases = [bends_of(np.ones_like(u), u, limit) for u, limit in zip(means, limits, strict=True)]
        self._level = are_level(lines.ends, limits)
        counts_of_bends = np.array([len(base) for base in bases])
        self._rows = LineRows.of(limits, means, lengths, counts_of_bends, np.flatnonzero(self._level))
        along = scipy.sparse.block_diag([(u - u.mean()).T / np.linalg.norm(u - u.mean()) for u in means], format="csr")
        linear = along[self._rows.owner[counts_of_bends.sum() :]]
        M = scipy.sparse.csr_array(scipy.sparse.vstack([scipy.sparse.block_diag(bases), linear]))
        self._points = mapping.hold_points(at, M, np.concatenate([share for _, share in samples]))
        with one_thread():
            self._give = (self._points.half.T @ self._points.half) @ M.T
        self._P = np.asarray(M @ self._give)
        cell = float(np.sqrt(grid.cell[0] * grid.cell[1]))
        self._softness = (cell * (counts - 1) / (weight * lengths[: self.count]))[self._rows.owner]
        self._fixed = fixed_directions(lines.ends, limits)
        self._ends = np.cumsum(counts) - counts, np.cumsum(counts) - 1
        self._glide = _Glide.of(mapping, lines.ends[: self.count].reshape(-1, 2), self._points)

    def straighten(self, found: Solution, w: Complexes, *, glides: bool = False) -> Pull | None:
        """Return what draws the lines of a solution for W straight, as they give way, with features where they are.

        Where it `glides`, the frame moves along its sides with the lines that end there. None where there are no lines.
        """
        if not self.count:
            return None
        points, glide = self._points, self._glide if glides else self._glide.none()
        there, unkept = ((z.ravel()[points.nodes] * points.weights).sum(axis=1) for z in (found.z, w))
        fixed = self._fixed.copy()
        fixed[self._level] = along_lines(unkept[self._ends[1]] - unkept[self._ends[0]], 0 * fixed)[self._level]
        read = points.M @ there
        forces, moves = np.zeros(len(read), np.complex128), np.zeros(len(glide.along), np.complex128)
        with one_thread():
            for _ in range(_ROUNDS):
                now = there + self._give @ forces + glide.at_points @ moves
                u = self._rows.directions(along_lines(now[self._ends[1]] - now[self._ends[0]], fixed))
                excess = self._rows.excess((np.conj(u) * read).real)
                on = np.flatnonzero(self._rows.bends | (excess != 0))
                system = self._P[np.ix_(on, on)] * (np.conj(u[on])[:, None] * u[on]).real + np.diag(self._softness[on])
                G = (np.conj(u[on])[:, None] * glide.along).real * glide.rows[on]
                given = np.linalg.solve(glide.stiffness, G.T)
                pulls = np.linalg.solve(system + G @ given, -excess[on])
                forces[:], forces[on], moves = 0, u[on] * pulls, glide.along * (given @ pulls)
        load = np.zeros(found.z.size, np.complex128)
        np.add.at(load, points.nodes, points.weights * np.asarray(points.M.T @ forces)[:, None])
        shape = found.z.shape
        return Pull(load.reshape(shape), np.asarray(glide.shapes @ moves, np.complex128).reshape(shape))


def _sample(count: int, places: int) -> tuple[Floats, Floats]:
    """Return where samples of a line read it, 0 to 1 (count, s), at about so many `places`, and their shares.

    A sample is a mean that fades to the samples beside it. So its force is spread along the line: at single points it
    would draw them out of their surroundings.
    """
    offset = np.linspace(-1, 1, 2 * max(places // 2, 2) + 1)[1:-1]
    at = (np.arange(count)[:, None] + offset) / (count - 1)
    share = np.where((at < 0) | (at > 1), 0, 1 - np.abs(offset))
    return np.clip(at, 0, 1), share / share.sum(axis=1, keepdims=True)


@dataclass(frozen=True, eq=False)
class _Glide:
    """Moves of the frame along its sides, one (q) for each place where lines end on it."""

    along: Complexes
    """Their directions (q,)."""
    shapes: Floats
    """U (N, q)."""
    half: HalfSolved
    """-L⁻¹ P K U (N, q): how free nodes follow."""
    at_points: Floats
    """What both do to the samples (m, q),"""
    rows: Floats
    """and F, what they do to the rows of M (k, q)."""
    stiffness: Floats
    """S (q, q), with nothing between moves along x and along y."""

    @classmethod
    def of(cls, mapping: FeatureMapping, ends: Points, points: HeldPoints) -> "_Glide":
        """Prepare those of the places where some of the `ends` (n, 2) of lines lie on the frame."""
        grid = mapping.grid
        shapes = slides_of(grid, mapping.index, ends)
        along = np.array([d for d, _ in shapes], np.complex128)
        edges = edge_weights(mapping.follow_w + mapping.follow_feature)
        U = np.array([u for _, u in shapes]).reshape(len(along), grid.size).T
        KU = np.array([laplacian(edges, u) for _, u in shapes]).reshape(len(along), grid.size).T
        with one_thread():
            half = mapping.factor.forward(np.where(mapping.free.ravel()[:, None], -KU, 0))
            at_points = (U[points.nodes] * points.weights[..., None]).sum(axis=1) + points.half.T @ half
            stiffness = U.T @ KU - half.T @ half
        same = (np.conj(along)[:, None] * along).real
        return cls(along, U, half, at_points, np.asarray(points.M @ at_points), same * stiffness)

    def none(self) -> "_Glide":
        """Return that the frame stays."""
        parts = (part[:, :0] for part in (self.shapes, self.half, self.at_points, self.rows, self.stiffness[:0]))
        return _Glide(self.along[:0], *parts)


_SIDES: list[tuple[complex, tuple[Any, int, int]]] = [
    (1, (np.s_[0], 0, 0)),
    (1, (np.s_[-1], 0, -1)),
    (1j, (np.s_[:, 0], 1, 0)),
    (1j, (np.s_[:, -1], 1, -1)),
]
"""Of the four sides, along which direction they run, their nodes, along which axis, and which end of the other."""


def slides_of(grid: Grid, index: Ints, ends: Points) -> list[tuple[complex, Floats]]:
    """Return along what, and by which shapes (R, C), a frame slides with the `ends` (n, 2) of lines that are on it.

    `index` (R, C) is the body of each node; those of bodies, and corners, stay.
    """
    return [(d, shape) for d, side in _SIDES for shape in _hats(grid, index, ends, side)]


def _hats(grid: Grid, index: Ints, ends: Points, side: tuple[Any, int, int]) -> list[Floats]:
    """Return the shares (R, C) by which the nodes of a side move with each place on it where lines end.

    Between such places, bodies (`index` (R, C) is that of each node) and corners, they run linearly.
    """
    nodes, axis, end = side
    size = grid.shape[1 - axis], grid.shape[axis]
    cells = (ends + 0.5) / grid.cell
    on_side = np.abs(cells[:, 1 - axis] - (0 if end == 0 else size[1] - 1)) < _ON_FRAME
    held = index[nodes] >= 0
    held[[0, -1]] = True
    stays = np.flatnonzero(held).astype(np.float64)
    places: list[float] = []
    for place in np.sort(cells[on_side, axis]).tolist():
        if min(abs(place - other) for other in (*stays, *places)) >= _APART:
            places.append(place)
    found = []
    for place in places:
        knots = np.sort(np.concatenate([stays, places]))
        hat = np.zeros(grid.shape)
        hat[nodes] = np.interp(np.arange(size[0]), knots, (knots == place).astype(float))
        found.append(hat)
    return found
