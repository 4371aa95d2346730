"""The unknowns of a map: which there are in a window, how they are numbered, and how nodes move with them.

Inner nodes and loose outline nodes have two each, gliding nodes one, bodies up to four: (ρ, φ, x, y), by which a node
at arm p - pivot moves by (α (p - pivot), i α (p - pivot), 1, i).
"""

from dataclasses import dataclass, field, replace

import numpy as np

from core.arrays import Bools, Floats
from core.mapping.handles.constraints import ALONG_X, ALONG_Y, SCALE, TURN
from core.mapping.injective.boundary_contact import BoundaryContacts
from core.mapping.injective.levels import GridLevel, Map
from core.mapping.injective.outline import Gliders
from core.mapping.jacobians import Complexes

_MOST_GROWTH = 20.0
"""Logarithm of a change of size that a step is cut to: a trial step far too long stays a number, and is refused."""


@dataclass(frozen=True, eq=False)
class Freedoms:
    """What may move or give way, beside inner nodes and what the constraints leave free."""

    yields: Bools = field(default_factory=lambda: np.zeros((), bool))
    """Bodies (n,) whose size may change."""
    moves: bool = True
    """Whether bodies move at all."""
    loose: Bools | None = None
    """Outline nodes (N,) that may leave the outline."""
    driven: Bools | None = None
    """Held freedoms of bodies (n, 4) that are drawn to their goal, as points then are, instead of held there."""


NOTHING_YIELDS = Freedoms()


@dataclass(frozen=True)
class Iterate:
    """A map, with the nodes of contacts after those of the grid, and the arc lengths of gliding nodes."""

    z: Complexes
    alpha: Complexes
    place: Complexes
    arcs: Floats


class Unknowns:
    """Those of the nodes (N,) of a window and of the bodies in it; what lies outside stays where `start` has it."""

    def __init__(
        self, level: GridLevel, start: Map, window: Bools, freedoms: Freedoms, contacts: BoundaryContacts
    ) -> None:
        self._level = level
        self.index = np.concatenate([level.index, contacts.index])
        """Body of every node, -1 for none."""
        self._find_bodies(contacts, window, freedoms)
        self._number(window, freedoms)
        z = np.concatenate([start.z, contacts.shape])
        self.start = self._placed(Iterate(z, start.alpha, start.place, self._gliders.arcs_of(start.z)))

    def _find_bodies(self, contacts: BoundaryContacts, window: Bools, freedoms: Freedoms) -> None:
        """Find the bodies that move, with all their nodes and arms from their pivots."""
        level = self._level
        moving = np.zeros(len(level.constraints.pivots) + 1, bool)
        if freedoms.moves:
            moving[level.index[window]] = True
        moving[-1] = False
        self.active = np.flatnonzero(moving)
        """Bodies that move."""
        self._nodes = np.flatnonzero(moving[self.index])
        self._of = self.index[self._nodes]
        rest = np.concatenate([level.rest, contacts.rest])
        self._arms = rest[self._nodes] - level.constraints.pivots[self._of]

    def _number(self, window: Bools, freedoms: Freedoms) -> None:
        """Give all unknowns their numbers."""
        level, held = self._level, self._level.constraints
        size, n = level.grid.size, len(held.pivots)
        loose, glide = np.zeros(size, bool), held.glide.ravel() & window
        if freedoms.loose is not None:
            loose = freedoms.loose & window & (level.index < 0)
            glide &= ~loose
        self._gliders = Gliders(level.outline, level.grid, glide.reshape(level.grid.shape))
        free = (level.inner & window) | loose
        on = np.zeros((len(self.index), 4), bool)
        on[:size][free, :2] = True
        on[self._gliders.nodes, 0] = True
        self.driven = np.zeros((n, 4), bool) if freedoms.driven is None else freedoms.driven & ~held.free
        """Freedoms of bodies (n, 4) that are drawn to their goal."""
        body_on = np.zeros((n + 1, 4), bool)
        body_on[self.active] = (held.free | self.driven)[self.active]
        body_on[:-1, SCALE] &= freedoms.yields
        self.yields = body_on[:-1, SCALE]
        """Bodies (n,) whose size is unknown."""
        self.count = int(on.sum() + body_on.sum())
        self.of_nodes, self.of_bodies = np.full(on.shape, self.count), np.full(body_on.shape, self.count)
        """Numbers of the unknowns of nodes (·, 4) and bodies (n + 1, 4); `count` stands for none."""
        self.of_nodes[on] = np.arange(on.sum())
        self.of_bodies[body_on] = on.sum() + np.arange(body_on.sum())
        self.of_nodes[self._nodes] = self.of_bodies[self._of]
        self._free, self.loose = np.flatnonzero(free), np.flatnonzero(loose)
        self.special = np.zeros(len(on), bool)
        """Nodes that do not move by their own x and y."""
        self.special[self._nodes] = self.special[self._gliders.nodes] = True
        self._directions = np.zeros((len(on), 4), np.complex128)
        self._directions[self._free, :2] = 1, 1j

    def moves(self) -> Bools:
        """Return the nodes that any unknown moves."""
        return np.asarray((self.of_nodes < self.count).any(axis=1))

    def _placed(self, state: Iterate) -> Iterate:
        """Return the state with nodes of moving bodies where their poses have them, gliding nodes on the outline."""
        z = state.z.copy()
        z[self._nodes] = state.place[self._of] + state.alpha[self._of] * self._arms
        z[self._gliders.nodes] = self._gliders.places(state.arcs)
        return replace(state, z=z)

    def moved(self, state: Iterate, step: Floats) -> Iterate:
        """Return the state after a step (count,)."""
        step = np.append(step, 0.0)
        z, alpha, place = state.z.copy(), state.alpha.copy(), state.place.copy()
        z[self._free] += step[self.of_nodes[self._free, :2]].view(np.complex128)[:, 0]
        by = step[self.of_bodies[self.active]]
        grown = np.clip(by[:, SCALE], -_MOST_GROWTH, _MOST_GROWTH)
        alpha[self.active] *= np.exp(grown + 1j * by[:, TURN])
        place[self.active] += by[:, ALONG_X] + 1j * by[:, ALONG_Y]
        return self._placed(Iterate(z, alpha, place, state.arcs + step[self.of_nodes[self._gliders.nodes, 0]]))

    def directions(self, state: Iterate) -> Complexes:
        """Return how nodes (·, 4) move with their unknowns."""
        by = self._directions
        by[self._nodes] = 1, 1, 1, 1j
        by[self._nodes, 0] = state.z[self._nodes] - state.place[self._of]
        by[self._nodes, 1] = 1j * by[self._nodes, 0]
        by[self._gliders.nodes, 0] = self._gliders.tangents(state.arcs)
        return by
