"""Untangle a mapping by Newton's method, features moving as one  [FAT sec. 5 leaves it as future work].

Unknown are free nodes and, of every feature, a move, a turn and a change of size: t and α = α₀ exp(ρ + iφ). A node of
the grid therefore follows at most four unknowns. The energy is a sum over quads,

    w₄ Σ |dz - dW|² + w₃ Σ |dz - α dp|² + μ f(z),

the first two those of FAT eqs. 4 and 3 in units of a cell's area, f a penalty on folds, and over features, which are
to have the scale s: k/2 (log |α| / s)². Where the outline gives way, the energy of `release` holds it.
"""

import numpy as np

from core.arrays import Bools, Floats, Ints
from core.mapping.assembly import Assembly, packed, triangle
from core.mapping.distortion import Corners, Penalty, edges_of
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.folds import corner_areas
from core.mapping.frames import Complexes, as_complex
from core.mapping.release import Leash, around, crosses_itself
from core.tracing import span

_FOLLOW_AT_MOST = 4.0
"""w₃ at most: around a feature that does not fit, the band that follows it gives way first."""
_HALVINGS = 10
_DESCENT = 1e-4
_FURTHEST, _WORTH = 4.0, 1.3
"""Length of a step at most, and that from which one more evaluation of the energy is worth it."""
# Σ |d z|² over the four edges of a quad, on (x0, y0, ..., x3, y3).
_RING = packed(np.kron(2 * np.eye(4) - np.roll(np.eye(4), 1, axis=0) - np.roll(np.eye(4), -1, axis=0), np.eye(2))[None])


class Untangler:
    """Newton's method in a window of the grid; what lies outside stays where it is.

    Parameters
    ----------
    window
        Nodes (R, C) that may move; features that have a node in it move as a whole.
    stiffness
        k of every feature, inf to hold its scale. None holds all features where they are.
    scales
        s of every feature, by default the scale it has at the start.
    released
        Outline nodes (R, C) outside features that may leave W, none by default.
    clear
        Whether no step may fold anything as long as nothing is folded.
    """

    def __init__(
        self,
        mapping: FeatureMapping,
        w: Complexes,
        start: Solution,
        *,
        window: Bools,
        stiffness: Floats | None,
        scales: Floats | None = None,
        released: Bools | None = None,
        clear: bool = False,
    ) -> None:
        self.mapping, self.w, self._clear = mapping, w, clear
        self._scales = np.abs(start.alpha) if scales is None else scales
        self._sizes = np.full(len(start.alpha), np.inf) if stiffness is None else stiffness
        self.z, self.alpha, self.t = start.z.ravel().copy(), start.alpha.copy(), start.t.copy()
        index = mapping.index.ravel() if len(self.alpha) else np.full(mapping.grid.size, -1)
        self._index = index
        self._active = np.unique(index[(index >= 0) & window.ravel() & (stiffness is not None)])
        loose = mapping.free if released is None else mapping.free | released
        moving = (loose & window).ravel() | np.isin(index, self._active)
        self._number_unknowns(moving, index)
        self._choose_quads(moving, w)
        self._unit = float(np.abs(corner_areas(w)).mean())
        self._leash = Leash(mapping.grid, index < 0, moving, w, self._unit)
        gives_way = released is not None and bool(moving[mapping.grid.outline.ravel()].any())
        self._ring = around(mapping.grid) if gives_way else None
        self._index_elements()
        self._measured = self.z, self._corners.determinants(self.z[self._places])
        self._told: tuple[Complexes, bool] | None = None

    def _choose_quads(self, moving: Bools, w: Complexes) -> None:
        """Choose the quads that are not one body's all through and have a node that moves, or that follow a feature."""
        mapping, index, quads = self.mapping, self._index, self.mapping.grid.quads
        inside = (index[quads] == index[quads[:, :1]]).all(axis=1) & (index[quads[:, 0]] >= 0)
        owned = np.isin(mapping.owner.ravel(), self._active)
        chosen = np.flatnonzero((moving[quads].any(axis=1) | owned) & ~inside)
        self._quads, self._owner = quads[chosen], mapping.owner.ravel()[chosen]
        self._w4 = mapping.follow_w.ravel()[chosen]
        self._w3 = np.minimum(mapping.follow_feature.ravel()[chosen], _FOLLOW_AT_MOST)
        self._places = np.ascontiguousarray(self._quads.T)
        corners = w.ravel()[self._places]
        self._wanted, _ = edges_of(corners)
        if not len(self.alpha):
            # Nothing moves as one: every quad is to keep the edges that it has.
            self._owner, self._w3, self._w4 = np.full(len(chosen), -1), self._w3 * 0, self._w3 + self._w4
            self._wanted, _ = edges_of(self.z[self._places])
        self._rest, _ = edges_of(as_complex(mapping.grid.nodes).ravel()[self._places])
        self._corners = Corners.of(corners)

    def _number_unknowns(self, moving: Bools, index: Ints) -> None:
        """Give every node its unknowns (N, 4); `_count` stands for none."""
        free = np.flatnonzero(moving & (index < 0))
        features = 4 * np.arange(len(self._active))[:, None] + 2 * len(free) + np.arange(4)
        self._count = 2 * len(free) + 4 * len(self._active)
        self._free = free
        self._dofs = np.full((len(index), 4), self._count)
        self._dofs[free, 0] = 2 * np.arange(len(free))
        self._dofs[free, 1] = self._dofs[free, 0] + 1
        self._feature_dofs = np.full((len(self.alpha) + 1, 4), self._count)
        self._feature_dofs[self._active] = features
        self._feature_dofs[:-1][np.isinf(self._sizes), 0] = self._count
        for i in self._active:
            self._dofs[self.mapping.bodies[i].nodes] = self._feature_dofs[i]

    def _index_elements(self) -> None:
        """Split quads into those of free nodes only and those with a feature, and find their entries in the matrix."""
        bound = np.isin(self._index[self._quads], self._active).any(axis=1) | np.isin(self._owner, self._active)
        self._plain, self._bound = np.flatnonzero(~bound), np.flatnonzero(bound)
        plain = self._dofs[self._quads[self._plain], :2].reshape(-1, 8)
        owner = self._feature_dofs[self._owner[self._bound], :2]
        tied = np.concatenate([self._dofs[self._quads[self._bound]].reshape(-1, 16), owner], axis=1)
        leashed = self._dofs[self._leash.edges, :2].reshape(-1, 4)
        self._assembly = Assembly(self._count, [plain, tied, leashed])

    def step(self, penalty: Penalty, weight: float) -> bool:
        """Take one Newton step with f = `penalty` and μ = `weight`; return whether it lowered the energy."""
        if not self._count:
            return False
        with span("untangle", unknowns=self._count):
            gradient, values = self._model(penalty, weight)
            move = -self._assembly.solve(values, gradient)
            before, slope, length = self._energy(penalty, weight), float(gradient @ move), 1.0
            kept, simple, folded = (self.z, self.alpha, self.t), self._is_simple, self.worst <= 0
            for _ in range(_HALVINGS):
                self._move(move * length)
                after = self._energy(penalty, weight)
                lower = after <= before + _DESCENT * length * slope
                if lower and (folded or not self._clear or self.worst > 0) and (self._is_simple or not simple):
                    if folded and length == 1 and slope < 0:
                        self._go_on(move, penalty, weight, after, 2 * (1 - (after - before) / slope))
                    return True
                self.z, self.alpha, self.t = kept
                length /= 2
        return False

    def _go_on(self, move: Floats, penalty: Penalty, weight: float, energy: float, bend: float) -> None:
        """Go on along a step that led to `energy` where it bent less than the model, as it does on deep folds.

        `bend` is the energy's curvature along the step over the model's.
        """
        length = 1 / max(bend, 1 / _FURTHEST)
        if length < _WORTH:
            return
        kept, simple = (self.z, self.alpha, self.t), self._is_simple
        self._move(move * (length - 1))
        if self._energy(penalty, weight) >= energy or (simple and not self._is_simple):
            self.z, self.alpha, self.t = kept

    def tie(self, nodes: Bools, strength: float) -> None:
        """Tie outline nodes (R, C) that may leave W to it, in addition to what holds them all."""
        self._leash.tie(nodes.ravel(), strength)

    @property
    def _is_simple(self) -> bool:
        """Whether an outline that gives way keeps clear of itself; found out once for each z."""
        if self._ring is None:
            return True
        if self._told is None or self._told[0] is not self.z:
            self._told = self.z, not crosses_itself(self.z[self._ring])
        return self._told[1]

    @property
    def size(self) -> int:
        """The number of unknowns."""
        return self._count

    @property
    def worst(self) -> float:
        """The least area of a corner relative to W."""
        return float(self._determinants.min(initial=np.inf))

    @property
    def stuck(self) -> float:
        """The least area of a corner relative to W that no move changes, since none of its three nodes moves."""
        still = (self._dofs[self._places] == self._count).all(axis=-1)
        held = still & still[[1, 2, 3, 0]] & still[[3, 0, 1, 2]]
        return float(self._determinants[held].min(initial=np.inf))

    @property
    def side(self) -> float:
        """The side of a cell."""
        return float(np.sqrt(self._unit))

    @property
    def folds(self) -> int:
        """The number of folded quads."""
        if self.worst > 0:
            return 0
        return int((self._determinants <= 0).any(axis=0).sum())

    @property
    def _determinants(self) -> Floats:
        """D of the corners of all quads chosen (4, m), worked out once for each z."""
        of, found = self._measured
        if of is not self.z:
            found = self._corners.determinants(self.z[self._places])
            self._measured = self.z, found
        return found

    @property
    def solution(self) -> Solution:
        """Where everything is now."""
        return Solution(self.z.reshape(self.mapping.grid.shape).copy(), self.alpha.copy(), self.t.copy())

    def _edges(self) -> tuple[Complexes, Complexes, Complexes]:
        """Return the feature's edges and the residuals of FAT eqs. 4 and 3, (4, m) each."""
        edges, _ = edges_of(self.z[self._places])
        turned = np.append(self.alpha, 0)[self._owner] * self._rest
        return turned, edges - self._wanted, edges - turned

    def _energy(self, penalty: Penalty, weight: float) -> float:
        _, plain, halo = self._edges()
        quadratic = self._w4 * _squares(plain) + self._w3 * _squares(halo)
        folds = penalty.energy(self._corners, self.z[self._places])
        held = self._size_energy() + self._leash.energy(self.z)
        return float(quadratic.sum() / (2 * self._unit) + weight * folds.sum() + held)

    def _size_energy(self) -> float:
        held = np.isfinite(self._sizes)
        return float((self._sizes[held] * self._stretch[held] ** 2).sum() / 2)

    @property
    def _stretch(self) -> Floats:
        """Logarithm of each feature's scale over the one wanted."""
        return np.asarray(np.log(np.abs(self.alpha) / self._scales))

    def _model(self, penalty: Penalty, weight: float) -> tuple[Floats, Floats]:
        """Return the gradient of the energy and the entries of its second derivative."""
        gradient, H = penalty.model(self._corners, self.z[self._places])
        gradient *= weight
        H *= weight
        turned, plain, halo = self._edges()
        w3, w4 = self._w3 / self._unit, self._w4 / self._unit
        pull = w4 * plain + w3 * halo
        gradient += _by_quads(pull[[3, 0, 1, 2]] - pull)
        H += (w3 + w4)[:, None] * _RING
        bound = self._bound
        T = self._directions()
        wide = np.zeros((len(bound), 10, 10))
        row, column = triangle(8)
        wide[:, row, column] = wide[:, column, row] = H[bound]
        w3, turned, halo = w3[bound], turned[:, bound], halo[:, bound]
        across = w3 * (turned - turned[[3, 0, 1, 2]])
        wide[:, :8, 8], wide[:, :8, 9] = _by_quads(across), _by_quads(1j * across)
        wide[:, 8:, :8] = wide[:, :8, 8:].transpose(0, 2, 1)
        wide[:, 8, 8] = wide[:, 9, 9] = w3 * _squares(turned)
        slope = np.zeros((len(bound), 10))
        slope[:, :8] = gradient[bound]
        along = -w3 * (np.conj(turned) * halo).sum(axis=0)
        slope[:, 8], slope[:, 9] = along.real, along.imag
        small = T.transpose(0, 2, 1) @ wide @ T
        away, pull_back = self._leash.model(self.z)
        values = self._assembly.entries([H[self._plain], packed(small), pull_back])
        ends = (slope[:, None, :] @ T)[:, 0]
        total = self._assembly.gradient([gradient[self._plain], ends, away])
        for i in self._active[np.isfinite(self._sizes[self._active])]:
            unknown = self._feature_dofs[i, 0]
            total[unknown] += self._sizes[i] * self._stretch[i]
            values[self._assembly.diagonal[unknown]] += self._sizes[i]
        return total, values

    def _directions(self) -> Floats:
        """Return how corners and owners of bound quads (n, 10) move with their unknowns (n, 18)."""
        nodes = self._quads[self._bound]
        index = self._index[nodes]
        active = np.isin(index, self._active)
        arm = np.where(active, self.z[nodes] - np.append(self.t, 0)[index], 1)
        T = np.zeros((len(nodes), 10, 18))
        for k in range(4):
            x, first = 2 * k, 4 * k
            T[:, x, first], T[:, x + 1, first] = arm[:, k].real, np.where(active[:, k], arm[:, k].imag, 0)
            T[:, x, first + 1] = np.where(active[:, k], -arm[:, k].imag, 0)
            T[:, x + 1, first + 1] = arm[:, k].real
            T[:, x, first + 2] = T[:, x + 1, first + 3] = active[:, k]
        T[:, 8, 16] = T[:, 9, 17] = 1
        return T

    def _move(self, move: Floats) -> None:
        """Follow the unknowns by `move`."""
        moves = np.append(move, 0.0)
        self.z, self.alpha, self.t = self.z.copy(), self.alpha.copy(), self.t.copy()
        self.z[self._free] += moves[: 2 * len(self._free)].view(np.complex128)
        by = moves[self._feature_dofs[self._active]]
        self.alpha[self._active] *= np.exp(by[:, 0] + 1j * by[:, 1])
        self.t[self._active] += by[:, 2] + 1j * by[:, 3]
        for i in self._active:
            body = self.mapping.bodies[i]
            self.z[body.nodes] = body.place(self.alpha[i], self.t[i])


def _by_quads(vectors: Complexes) -> Floats:
    """Return vectors at the corners of quads (4, m) as x0, y0, ..., x3, y3 (m, 8)."""
    return np.ascontiguousarray(vectors.T).view(np.float64)


def _squares(edges: Complexes) -> Floats:
    """Return Σ |e|² over the four edges of every quad, (4, m)."""
    return np.asarray((edges.real**2 + edges.imag**2).sum(axis=0))
