"""The ways from a linear answer that folds to a map that does not, and their order; `unfold` tells of both."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.handles.constraints import SCALE
from core.mapping.handles.curved_frame import LEAST
from core.mapping.injective.boundary_contact import BoundaryContacts
from core.mapping.injective.continuation import (
    FEW_STEPS,
    GENTLE_FALL,
    LIGHT,
    ROOM,
    ROOMY,
    STEPS,
    clear_folds,
    is_met,
    relax,
)
from core.mapping.injective.levels import GridLevel, Map, Transfer
from core.mapping.injective.outline import CORNERS, nodes_beside_cuts
from core.mapping.injective.problem import Goal, Problem
from core.mapping.injective.refinement import FEW, MANY, REACH, Refinement, preview
from core.mapping.injective.starts import part_of_the_way, posed, similar, small
from core.mapping.injective.unknowns import Freedoms
from core.mapping.injective.windows import count_folds, misses, window_around
from core.mapping.jacobians import Complexes
from core.mapping.tolerances import MET_PX, ROUNDING
from core.progress import Job

_COARSE, _FINER = 17.0, 0.67
"""Nodes of the coarse grid over the root of those of the fine one; its cells in a second attempt, over the first."""
_BESIDE = 40
"""Outline nodes either side of a cut that may glide or leave the outline."""
_WORTH = 0.1
"""Share of its size that a body is to keep before the outline gives way."""
_WIDER = 3
"""Points that cannot be brought to their targets in a narrow window are tried in one so many times wider."""


class Ways:
    """The ways from a linear answer that folds to a map that does not."""

    def __init__(self, mapping: FeatureMapping, level: GridLevel, linear: Map, goal: Goal, centres: Complexes) -> None:
        self._mapping, self._centres = mapping, centres
        self._level, self._linear, self._goal = level, linear, goal
        self._refinement = Refinement(mapping, linear, goal, centres)

    def find(self, safe: Map | None, near: Map | None = None) -> Job[Map | None]:
        """Try one way after the other; of those that do not bring all points to their targets, the closest counts."""
        best, least = safe, np.inf
        if safe is None and not self._level.constraints.glide.any():
            best = similar(self._level)
        for way in self._in_order(safe, near):
            found = yield from way
            if found is None or count_folds(self._level, found.z):
                continue
            miss = float(misses(self._level, found.z).max(initial=0))
            if miss < least:
                best, least = found, miss
            if least < MET_PX:
                break
        if best is safe and safe is not None:
            return part_of_the_way(self._level, safe, self._linear)
        return best if best is None or not MET_PX < least < self._level.side else (yield from self._brought_home(best))

    def _brought_home(self, found: Map) -> Job[Map]:
        """Return a map without folds with points that are all but on their targets brought there, if nothing folds.

        Points that are a cell off and more could not be drawn nearer: they would be a needle between features.
        """
        level = self._level
        for reach in (REACH, _WIDER * REACH):
            window = window_around(level, found.z, reach, bodies=reach > REACH)
            problem = Problem(level, found, self._goal, window=window)
            yield from relax(problem, steps=STEPS)
            if is_met(problem) and not count_folds(level, problem.found.z):
                return problem.found
        return found

    def _in_order(self, safe: Map | None, near: Map | None) -> Iterator[Job[Map | None]]:
        level = self._level
        cells = max(1.0, level.grid.size**0.25 / _COARSE**0.5)
        yield self._nearby(self._linear, FEW)
        if near is not None:
            yield self._nearby(posed(self._mapping, level, self._goal, near, self._centres), MANY)
            yield self._from_coarse(level, cells, begin=near)
        yield self._from_coarse(level, cells)
        yield self._beside_cuts(cells, safe)
        if safe is None:
            yield self._from_coarse(level, max(1.0, _FINER * cells))
        begin = small(self._level, self._goal) if safe is None and level.constraints.glide.any() else safe
        yield self._drawn(begin, cells)

    def _beside_cuts(self, cells: float, safe: Map | None) -> Job[Map | None]:
        """Let the outline beside cut bodies glide, or go.

        A map that has left the outline is shown, and kept unless there is one that has not.
        """
        level, gliding = self._level, self._gliding_beside_cuts()
        if gliding is None:
            return None
        left = yield from self._from_coarse(level, cells, leaves=True)
        if (
            left is None
            and safe is None
            and any(body.limits.least > 0 for body in self._mapping.bodies[: len(self._linear.alpha)])
        ):
            left = yield from self._smaller(cells)
        if left is None and safe is None:
            left = yield from self._from_safe(None, cells)
        start = self._linear
        for begin in (start, level.placed(level.shape.ravel(), start.alpha, start.place)):
            found = yield from self._from_coarse(gliding, cells, begin=begin)
            if found is not None:
                return found
        return left

    def _gliding_beside_cuts(self) -> GridLevel | None:
        """Return the level with outline nodes that glide beside cut bodies; None where there are none, or all glide."""
        level = self._level
        beside = nodes_beside_cuts(level.grid, level.index, _BESIDE)
        beside[CORNERS] = False
        if level.constraints.glide.any() or not beside.any():
            return None
        return replace(level, constraints=replace(level.constraints, glide=beside))

    def _nearby(self, start: Map, most: int) -> Job[Map | None]:
        """Clear folds, `most` of them at most, in windows on the fine grid, outline and sizes held."""
        level = self._level
        if count_folds(level, start.z) > most:
            return None
        problem = Problem(level, start, self._goal, window=window_around(level, start.z, REACH))
        if not (yield from clear_folds(problem, FEW_STEPS)):
            return None
        yield preview(level, problem.found)
        yield from relax(problem)
        return problem.found

    def _from_coarse(
        self, level: GridLevel, cells: float, *, leaves: bool = False, begin: Map | None = None
    ) -> Job[Map | None]:
        """Clear folds on a grid of larger cells, with outline nodes beside cuts that may leave it, and refine that."""
        way = Transfer(level, cells, held_outline=not leaves)
        coarse = way.coarse
        if not coarse.is_fit():
            return None
        contacts = BoundaryContacts.of(level, coarse, held_outline=not leaves)
        yields = level.constraints.free[:, SCALE] & (coarse.counts() > 0)
        beside = nodes_beside_cuts(coarse.grid, coarse.index, int(_BESIDE / cells)).ravel() if leaves else None
        start = way.restrict_map(self._linear if begin is None else begin)
        problem = Problem(coarse, start, self._goal, Freedoms(yields, loose=beside), contacts=contacts)
        if not (yield from clear_folds(problem)):
            return None
        yield from relax(problem)
        is_small = (np.abs(problem.state.alpha) < _WORTH * self._goal.scales).any()
        if is_small and not leaves and not level.constraints.glide.any():
            return None
        return (yield from self._refinement.finish(way, problem, contacts))

    def _drawn(self, safe: Map | None, cells: float) -> Job[Map | None]:
        """Draw all to its goals from a map without folds, on a finer grid if that fails on this one."""
        found = yield from self._from_safe(safe, cells)
        return found or (yield from self._from_safe(safe, max(1.0, _FINER * cells)))

    def _from_safe(self, safe: Map | None, cells: float) -> Job[Map | None]:
        """Draw handles, sizes and outline to their goals from a map without folds."""
        level, goal, leaves = self._level, self._goal, safe is None
        start = similar(self._level) if safe is None else safe
        way = Transfer(level, cells, held_outline=not leaves)
        coarse, held = way.coarse, level.constraints
        if not coarse.is_fit():
            return None
        turned, shifted = np.log(start.alpha / goal.alpha), start.place - goal.place
        away = np.stack([turned.real, turned.imag, shifted.real, shifted.imag], axis=1)
        driven = ~held.free & (np.abs(away) > ROUNDING)
        yields = (held.free | driven)[:, SCALE] & (coarse.counts() > 0)
        contacts = BoundaryContacts.of(level, coarse, held_outline=not leaves)
        freedoms = Freedoms(yields, loose=coarse.grid.outline.ravel() if leaves else None, driven=driven)
        begin = way.restrict_map(start, held_outline=not leaves)
        alone = replace(coarse, constraints=replace(coarse.constraints, probes=held.probes[:0], to=held.to[:0]))
        cleared = Problem(alone, begin, goal, contacts=contacts)
        if not (yield from clear_folds(cleared)):
            return None
        problem = Problem(coarse, cleared.found, goal, freedoms, contacts=contacts)
        end = ROOMY if len(held.probes) or driven.any() else LIGHT
        roomy = problem.state
        for step in relax(problem, end=end, steps=STEPS, fall=GENTLE_FALL):
            roomy = problem.state if problem.worst() > ROOM else roomy
            yield step
        found = yield from self._refinement.finish(way, problem, contacts)
        if found is None and roomy is not problem.state:
            problem.state = roomy
            found = yield from self._refinement.finish(way, problem, contacts)
        return found

    def _smaller(self, cells: float) -> Job[Map | None]:
        """Begin with bodies where W alone has them, at the sizes λ they have there, and keep these if they do."""
        level, n = self._level, len(self._linear.alpha)
        alpha, t = np.array([body.fit(level.wanted.ravel()) for body in self._mapping.bodies[:n]], np.complex128).T
        sizes = self._mapping.sizes_under(level.wanted, np.arange(n))
        if (sizes < LEAST * self._goal.scales).any():
            return None
        turns = [body.limits.turns for body in self._mapping.bodies[:n]]
        alpha = np.asarray(sizes * np.exp(1j * np.angle(np.where(turns, alpha, 1))), np.complex128)
        linear = level.of_solution(self._mapping.place_at(level.wanted, alpha, t), self._centres)
        goal = Goal(sizes, linear.alpha, linear.place)
        return (
            yield from Ways(self._mapping, level, linear, goal, self._centres)._from_coarse(level, cells, leaves=True)
        )
