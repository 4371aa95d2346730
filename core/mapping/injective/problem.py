"""The energy of a map in a window of a grid, and its model for Newton's method; `unfold` states the whole problem."""

from dataclasses import dataclass

import numpy as np

from core.arrays import Bools, Floats, Ints
from core.linalg.assembly import Assembly, pack, triangle
from core.linalg.factor import Factor
from core.mapping.handles.constraints import ALONG_X, ALONG_Y, SCALE, TURN
from core.mapping.injective.barrier import AreaBarrier, edges_of
from core.mapping.injective.boundary_contact import NO_CONTACTS, BoundaryContacts
from core.mapping.injective.levels import GridLevel, Map
from core.mapping.injective.outline import crosses_itself, ring_of
from core.mapping.injective.springs import Springs
from core.mapping.injective.unknowns import NOTHING_YIELDS, Freedoms, Iterate, Unknowns
from core.mapping.jacobians import Complexes
from core.mapping.tolerances import ROUNDING

_SIZE_FRICTION, _OUTLINE_FRICTION, _HANDLE_FRICTION = 200.0, 20.0, 3e4
"""Strengths: of a size, by its logarithm and per node of the body; of a node's hold on the outline; of a point's or a
pinned pose's pull to its goal; the latter per cell."""
# Second derivative of half the squared lengths of a quad's edges, by the x and y of its corners.
_RING = pack(np.kron(2 * np.eye(4) - np.roll(np.eye(4), 1, axis=0) - np.roll(np.eye(4), -1, axis=0), np.eye(2))[None])


@dataclass(frozen=True)
class Goal:
    """What bodies are drawn to."""

    scales: Floats
    """Sizes (n,)."""
    alpha: Complexes
    place: Complexes
    """Poses (n,) of the linear answer; they count for driven freedoms alone."""


@dataclass(frozen=True)
class Model:
    """The energy about a state: its gradient, the entries of a positive semidefinite second derivative, C and c."""

    gradient: Floats
    entries: Floats
    rows: Complexes
    """C: how what points and rings read (k, m) changes with the unknowns of their quads."""
    miss: Complexes
    """c: how far points are from their targets (k,), in pixels."""


class Problem:
    """E over the unknowns of a window, by default of all of the grid, about a state that steps change."""

    def __init__(
        self,
        level: GridLevel,
        start: Map,
        goal: Goal,
        freedoms: Freedoms = NOTHING_YIELDS,
        *,
        window: Bools | None = None,
        contacts: BoundaryContacts = NO_CONTACTS,
    ) -> None:
        self.level, self.goal, self.contacts, self.side = level, goal, contacts, level.side
        self.grip = 1.0
        """What friction of sizes and of the outline is multiplied by."""
        self.is_driven = freedoms.driven is not None
        """Whether points and held freedoms of bodies are drawn to their goals instead of held there."""
        window = np.ones(level.grid.size, bool) if window is None else window
        self.unknowns = Unknowns(level, start, window, freedoms, contacts)
        self.state = self.unknowns.start
        self._counts = level.counts().astype(np.float64)
        self._choose_quads()
        self._choose_points()
        unknowns, quads = self.unknowns, self._at.T
        owners = unknowns.of_bodies[self._owner[self._bound], :2]
        bound = np.concatenate([unknowns.of_nodes[quads[self._bound]].reshape(-1, 16), owners], axis=1)
        plain = unknowns.of_nodes[quads[self._plain], :2].reshape(-1, 8)
        if unknowns.count:
            self._assembly = Assembly(unknowns.count, [plain, bound, self._point_dofs])

    def _choose_quads(self) -> None:
        """Take the quads that anything moves, but none all inside one body, and the corners of contacts."""
        level, unknowns, contacts = self.level, self.unknowns, self.contacts
        index, none = unknowns.index, np.zeros(len(contacts.corners))
        quads = np.concatenate([level.grid.quads, level.grid.size + contacts.corners[:, [0, 1, 1, 2]]])
        owner = np.concatenate([level.owner, np.full(len(none), -1)])
        inside = (index[quads] == index[quads[:, :1]]).all(axis=1) & (index[quads[:, 0]] >= 0)
        owned = np.isin(owner, unknowns.active)
        chosen = np.flatnonzero((unknowns.moves()[quads].any(axis=1) | owned) & ~inside)
        self._at, self._owner = np.ascontiguousarray(quads[chosen].T), owner[chosen]
        self._follow_wanted = np.concatenate([level.follow_wanted, none])[chosen] / self.side**2
        self._follow_body = np.concatenate([level.follow_body, none])[chosen] / self.side**2
        single = chosen >= len(level.grid.quads)
        at = np.where(single, 0, self._at)
        self._wanted, self._rest = edges_of(level.wanted.ravel()[at])[0], edges_of(level.rest[at])[0]
        self._barrier = AreaBarrier(np.concatenate([level.shape.ravel(), contacts.shape])[self._at], single)
        bound = unknowns.special[self._at].any(axis=0) | owned[chosen]
        self._plain, self._bound = np.flatnonzero(~bound), np.flatnonzero(bound)

    def _choose_points(self) -> None:
        """Take the points whose place anything moves."""
        held = self.level.constraints
        nodes, weights = held.probes.on(self.level.grid)
        moved = self.unknowns.moves()[nodes] & (np.abs(weights) > ROUNDING)
        self.points: Ints = np.flatnonzero(moved.any(axis=1))
        """Numbers of the points among those of the constraints."""
        self._point_nodes, self._point_weights = nodes[self.points], weights[self.points]
        self._point_to = held.to[self.points]
        self._point_dofs = self.unknowns.of_nodes[self._point_nodes].reshape(len(self.points), 4 * nodes.shape[1])

    @property
    def found(self) -> Map:
        """The map as it is now."""
        return Map(self.state.z[: self.level.grid.size], self.state.alpha, self.state.place)

    @property
    def holds_points(self) -> bool:
        """Whether steps are to meet points."""
        return bool(self.points.size) and not self.is_driven

    def determinants(self) -> Floats:
        """Return D (4, m) of the problem's quads."""
        return self._barrier.determinants(self.state.z[self._at])

    def worst(self) -> float:
        """Return the least D."""
        return float(self.determinants().min(initial=np.inf))

    def count_folds(self) -> int:
        """Return how many quads are folded."""
        return int((self.determinants() <= 0).any(axis=0).sum())

    def is_stuck(self) -> bool:
        """Return whether a corner is folded that nothing which moves has a part in."""
        moves = self.unknowns.moves()[self._at]
        return bool(((self.determinants() <= 0) & ~(moves | moves[[1, 2, 3, 0]] | moves[[3, 0, 1, 2]])).any())

    def crosses_itself(self, state: Iterate) -> bool:
        """Return whether the outline, where it is loose or free, crosses itself."""
        return bool(self.unknowns.loose.size or self.level.constraints.is_free) and crosses_itself(
            state.z[ring_of(self.level.grid)]
        )

    def misses(self, state: Iterate) -> Complexes:
        """Return how far points are from their targets (k,), in pixels."""
        return np.asarray((state.z[self._point_nodes] * self._point_weights).sum(axis=1) - self._point_to)

    def size_changes(self, state: Iterate) -> tuple[Ints, Floats]:
        """Return the bodies whose size may change, and the logarithms by which it has."""
        bodies = np.flatnonzero(self.unknowns.yields)
        return bodies, np.log(np.abs(state.alpha[bodies]) / self.goal.scales[bodies])

    def outline_changes(self, state: Iterate) -> Complexes:
        """Return how far loose nodes are from the outline, in cells."""
        loose = self.unknowns.loose
        return np.asarray((state.z[loose] - self.level.shape.ravel()[loose]) / self.side)

    def _springs(self, state: Iterate) -> list[Springs]:
        """Return what friction holds, beside points."""
        unknowns = self.unknowns
        bodies, change = self.size_changes(state)
        # A turn or a change of size moves a body's rim by its radius, in cells.
        pinned = _HANDLE_FRICTION * np.sqrt(self._counts)
        strength = np.where(
            unknowns.driven[bodies, SCALE], pinned[bodies], self.grip * _SIZE_FRICTION * self._counts[bodies]
        )
        found = [
            Springs(self._with_none(unknowns.of_bodies[bodies, SCALE]), change.astype(np.complex128), strength, 1.0)
        ]
        if unknowns.loose.size:
            away = self.outline_changes(state)
            strength = np.full(len(away), self.grip * _OUTLINE_FRICTION)
            found.append(Springs(unknowns.of_nodes[unknowns.loose, :2], away, strength, self.side))
        if self.is_driven:
            active = unknowns.active
            driven = unknowns.driven[active]
            dofs = np.where(driven, unknowns.of_bodies[active], unknowns.count)
            away = (state.place - self.goal.place)[active] / self.side
            away = np.where(driven[:, ALONG_X], away.real, 0) + 1j * np.where(driven[:, ALONG_Y], away.imag, 0)
            found.append(Springs(dofs[:, ALONG_X:], away, np.full(len(active), _HANDLE_FRICTION), self.side))
            turn = np.where(driven[:, TURN], np.angle(state.alpha / self.goal.alpha)[active], 0).astype(np.complex128)
            found.append(Springs(self._with_none(dofs[:, TURN]), turn, pinned[active], 1.0))
        return found

    def _with_none(self, dofs: Ints) -> Ints:
        """Return unknowns (m,) of real values as pairs."""
        return np.stack([dofs, np.full(len(dofs), self.unknowns.count)], axis=1)

    def _pulls(self, miss: Complexes) -> Springs:
        """Return what draws points to their targets."""
        return Springs(self._point_dofs[:, :2], miss / self.side, np.full(len(miss), _HANDLE_FRICTION), self.side)

    def _differences(self, state: Iterate) -> tuple[Complexes, Complexes, Complexes]:
        """Return α dp of quads' edges (4, m), and how far edges are from `wanted` and from α dp  [FAT eqs. 3, 4]."""
        turned = np.append(state.alpha, 0)[self._owner] * self._rest
        edges, _ = edges_of(state.z[self._at])
        return turned, edges - self._wanted, edges - turned

    def energy(self, state: Iterate, mu: float, epsilon: float) -> tuple[float, float]:
        """Return E and the least D."""
        _, plain, halo = self._differences(state)
        barrier, worst = self._barrier.energy(state.z[self._at], epsilon)
        total = float((self._follow_wanted * _squares(plain) + self._follow_body * _squares(halo)).sum() / 2)
        total += mu * barrier + sum(springs.energy for springs in self._springs(state))
        return total + (self._pulls(self.misses(state)).energy if self.is_driven else 0.0), worst

    def model(self, mu: float, epsilon: float) -> Model:
        """Return the energy's model about the state."""
        state = self.state
        gradient, curvature = self._barrier.model(state.z[self._at], epsilon)
        gradient *= mu
        curvature *= mu
        turned, plain, halo = self._differences(state)
        pull = self._follow_wanted * plain + self._follow_body * halo
        gradient += _by_quads(pull[[3, 0, 1, 2]] - pull)
        curvature += (self._follow_body + self._follow_wanted)[:, None] * _RING
        directions = self.unknowns.directions(state)
        slope, bent = self._bound_model(directions, gradient, curvature, turned, halo)
        rows = (directions[self._point_nodes] * self._point_weights[..., None]).reshape(self._point_dofs.shape)
        miss = self.misses(state)
        stiffness = self._pulls(miss).stiffness / self.side**2 if self.is_driven else np.zeros(len(miss))
        pulled = stiffness[:, None] * (np.conj(rows) * miss[:, None]).real
        entries = self._assembly.entries([curvature[self._plain], bent, _squared(rows, stiffness)])
        total = self._assembly.gradient([gradient[self._plain], slope, pulled])
        for springs in self._springs(state):
            springs.add_to(total, entries, self._assembly.diagonal)
        return Model(total, entries, rows, miss)

    def _bound_model(
        self, directions: Complexes, gradient: Floats, curvature: Floats, turned: Complexes, halo: Complexes
    ) -> tuple[Floats, Floats]:
        """Return gradient (b, 18) and second derivative, packed, of quads with bodies or gliding nodes.

        By all unknowns of their corners and the owner's ρ and φ. Before, they are by x and y and by the owner's alone.
        """
        b = self._bound
        by = directions[self._at[:, b]]
        T = np.zeros((len(b), 10, 18))
        for k in range(4):
            T[:, 2 * k, 4 * k : 4 * k + 4], T[:, 2 * k + 1, 4 * k : 4 * k + 4] = by[k].real, by[k].imag
        T[:, 8, 16] = T[:, 9, 17] = 1
        wide = np.zeros((len(b), 10, 10))
        row, column = triangle(8)
        wide[:, row, column] = wide[:, column, row] = curvature[b]
        weight, turned, halo = self._follow_body[b], turned[:, b], halo[:, b]
        across = weight * (turned - turned[[3, 0, 1, 2]])
        wide[:, :8, 8], wide[:, :8, 9] = _by_quads(across), _by_quads(1j * across)
        wide[:, 8:, :8] = wide[:, :8, 8:].transpose(0, 2, 1)
        wide[:, 8, 8] = wide[:, 9, 9] = weight * _squares(turned)
        slope = np.zeros((len(b), 10))
        slope[:, :8] = gradient[b]
        along = -weight * (np.conj(turned) * halo).sum(axis=0)
        slope[:, 8], slope[:, 9] = along.real, along.imag
        return (slope[:, None, :] @ T)[:, 0], pack(T.transpose(0, 2, 1) @ wide @ T)

    def factorise(self, model: Model, weights: Floats) -> Factor:
        """Factorise the second derivative with the squares of the points' rows added, by `weights` (k,)."""
        if not weights.size:
            return self._assembly.factorise(model.entries)
        none = [np.zeros((len(self._plain), 36)), np.zeros((len(self._bound), 171))]
        return self._assembly.factorise(model.entries + self._assembly.entries([*none, _squared(model.rows, weights)]))

    def stiffness_at_points(self, model: Model) -> Floats:
        """Return the greatest diagonal entry of the second derivative among each point's unknowns (k,)."""
        diagonal = np.append(model.entries[self._assembly.diagonal], 0.0)
        return np.asarray(diagonal[self._point_dofs].max(axis=1))

    def along(self, model: Model, step: Floats) -> Complexes:
        """Return C step: how far points (k,) move."""
        return np.asarray((model.rows * np.append(step, 0.0)[self._point_dofs]).sum(axis=1))

    def against(self, model: Model, forces: Complexes) -> Floats:
        """Return Cᵀ forces (count,) for forces on the points (k,)."""
        parts = (np.conj(model.rows) * forces[:, None]).real
        return np.asarray(np.bincount(self._point_dofs.ravel(), parts.ravel(), self.unknowns.count + 1)[:-1])


def _by_quads(corners: Complexes) -> Floats:
    """Return complex numbers (4, m) as x and y by quads (m, 8)."""
    return np.ascontiguousarray(corners.T).view(np.float64)


def _squares(edges: Complexes) -> Floats:
    """Return the sum of squared lengths (m,) of edges (4, m)."""
    return np.asarray((edges.real**2 + edges.imag**2).sum(axis=0))


def _squared(rows: Complexes, weight: Floats) -> Floats:
    """Return the second derivative of half the weighed squares of complex rows (k, m), packed."""
    one, other = triangle(rows.shape[1])
    return np.asarray(weight[:, None] * (np.conj(rows[:, one]) * rows[:, other]).real)
