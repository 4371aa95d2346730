"""What handles hold, and how: all that depends on where handles and features are, but not on where they go."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from core.arrays import Bools, Ints
from core.mapping.features.feature_mapping import JOINT_AT_MOST, FeatureMapping
from core.mapping.features.pose import HeldPoints
from core.mapping.features.similarity import Body
from core.mapping.handles.free_plate import FreePlate
from core.mapping.handles.motions import Motions
from core.mapping.handles.plate import HandleField, Plate
from core.mapping.handles.poses import Hold, find_holds, find_owners, sample_rim
from core.mapping.handles.probes import Probes
from core.mapping.handles.rods import Rods, slides_with
from core.mapping.handles.straight_frame import sides_cut
from core.mapping.jacobians import Complexes, as_complex, as_positions
from core.mapping.tolerances import LEAST_SHARE, ROUNDING

_MOST_NUMBERS = 4_000_000
"""Numbers in the responses of the points that free nodes hold, beside those of pins."""
_FEW = 12
"""So many features have many samples."""
_MANY_BLOCKS, _FEW_BLOCKS = 5.7, 2.3
"""Blocks along a feature's diameter: some twenty samples on its rim, or some six."""


@dataclass(frozen=True, eq=False)
class Structure:
    """The points that handles hold on a mapping, and those that the plate knows."""

    mapping: FeatureMapping
    probes: Probes
    """The handles (k)."""
    owners: Ints
    """The body that each is in, -1 for none."""
    holds: dict[int, Hold]
    """Of the bodies that have some."""
    cut: Bools
    """Which of the four sides cut which body (n, 4); none where the frame is free."""
    outside: Ints
    """The handles that no body holds and that lie inside the frame."""
    at_frame: Ints
    """The handles that no body holds and that lie on a held frame."""
    of_plate: Probes
    """The plate's: handles outside bodies, then points of the rims of bodies."""
    motions: Motions
    """How the bodies move that the plate knows."""
    blocks: float
    rims: dict[Body, Complexes]
    """Points sampled on each of these, from its centroid, and into how many blocks along a diameter it was cut."""
    held: HeldPoints
    rows: Ints
    """The handles that free nodes hold."""
    field: HandleField
    """The plate's answers."""
    alone: Bools
    """Which of the rows are pins in the background: held by free nodes only, each would draw out a spike."""

    @cached_property
    def small(self) -> Bools:
        """The bodies (n,) that the plate does not know."""
        return np.isin(np.arange(len(self.mapping.moved_bodies)), self.motions.bodies, invert=True)

    @cached_property
    def turns(self) -> Bools:
        """The bodies (n,) that do not stay upright."""
        return np.array([body.limits.turns for body in self.mapping.moved_bodies], bool)

    def holds_same(self, other: "Structure") -> bool:
        """Return whether free nodes hold the same handles alone."""
        if not self.probes.is_same(other.probes):
            return False
        return np.array_equal(self.rows[self.alone], other.rows[other.alone])


def prepare(
    mapping: FeatureMapping,
    probes: Probes,
    pins: Bools,
    plate: Plate | None,
    rods: Rods,
    known: Structure | None = None,
) -> Structure:
    """Return the structure of handles (k) for a mapping.

    Free nodes hold all `pins`; of the samples of curves, which the plate holds closely, as many as cost little. What is
    `known` of the same plate's answers is taken from there.
    """
    bodies, frame_is_held = mapping.moved_bodies, not isinstance(plate, FreePlate)
    rest = as_complex(mapping.grid.nodes)
    at, rings = probes.at, probes.are_rings
    owners = find_owners(mapping.index, mapping.grid, at) if bodies else np.full(len(at), -1)
    holds = {hold.body: hold for hold in find_holds(bodies, rest, owners, probes)}
    cut = np.zeros((len(bodies), 4), bool)
    if frame_is_held and bodies:
        cut = sides_cut(mapping)
    nodes, weights = probes.on(mapping.grid)
    weights = np.abs(weights)
    share = np.where(mapping.free.ravel()[nodes], weights, 0).sum(axis=1) / weights.sum(axis=1)
    idle = (owners < 0) & (share < LEAST_SHARE) & (frame_is_held | rings)
    outside, at_frame = np.flatnonzero((owners < 0) & ~idle), np.flatnonzero(idle & ~rings)
    sampled = [i for i in range(len(bodies)) if i < JOINT_AT_MOST or i in holds or cut[i].any()]
    blocks = _MANY_BLOCKS if len(sampled) <= _FEW else _FEW_BLOCKS
    rims = {} if known is None or known.blocks != blocks else known.rims
    chosen = [bodies[i] for i in sampled]
    arms = [rims[body] if body in rims else sample_rim(body, mapping.grid.shape, blocks) for body in chosen]
    middles = [rest.ravel()[bodies[i].nodes].mean() for i in sampled]
    points = [as_positions(part + middle) for part, middle in zip(arms, middles, strict=True)]
    motions = _find_motions(mapping, sampled, arms, holds, cut, first=len(outside))
    rows = np.where(owners < 0, share >= LEAST_SHARE, (share > ROUNDING) & ~rings)
    rows = _thin_out(np.flatnonzero(rows), pins, mapping)
    held = mapping.hold_points(*probes[rows].spread(mapping.grid))
    rim = Probes.of_points(np.concatenate([np.empty((0, 2)), *points]))
    of_plate = Probes(np.concatenate([at[outside], rim.at]), np.concatenate([probes.radius[outside], rim.radius]))
    whole = min(len(outside) + sum(2 - hold.is_one_place for hold in holds.values()), 2)
    before = None if known is None else known.field
    return Structure(
        mapping,
        probes,
        owners,
        holds,
        cut,
        outside,
        at_frame,
        of_plate,
        motions,
        blocks,
        dict(zip(chosen, arms, strict=True)),
        held,
        rows,
        HandleField(
            mapping.grid,
            plate,
            of_plate,
            spare=whole,
            rods=rods,
            slides=slides_with(rods, mapping, probes.at[at_frame]) if frame_is_held else (),
            bodies=motions.unknown,
            known=before,
        ),
        (pins & (owners < 0))[rows],
    )


def _thin_out(rows: Ints, pins: Bools, mapping: FeatureMapping) -> Ints:
    """Return those of the handles `rows` that free nodes hold: all pins, and every so manieth of the others."""
    others = rows[~pins[rows]]
    room = max(_MOST_NUMBERS // mapping.grid.size - int(pins[rows].sum()), 1)
    return np.sort(np.concatenate([rows[pins[rows]], others[:: max(-(-len(others) // room), 1)]]))


def _find_motions(
    mapping: FeatureMapping,
    sampled: list[int],
    arms: list[Complexes],
    holds: dict[int, Hold],
    cut: Bools,
    *,
    first: int,
) -> Motions:
    """Return how bodies move: one without a hold turns, and moves; one held at one place turns about it.

    One that stays upright does not turn, and bodies that the frame cuts stay.
    """
    is_free = np.array([i not in holds for i in sampled], bool)
    is_held = np.array([i in holds and holds[i].is_one_place for i in sampled], bool)
    about = np.array([holds[i].arm if i in holds else 0 for i in sampled], np.complex128)
    turns = np.array([mapping.bodies[i].limits.turns for i in sampled], bool)
    inner = ~cut[sampled].any(axis=1)
    return Motions.of(sampled, arms, first, about, turns & inner & (is_free | is_held), inner & is_free)
