"""The ways from a linear answer that folds to a map that does not, and their order; `unfold` tells of both."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from core.arrays import Bools
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.handles.constraints import SCALE
from core.mapping.handles.curved_frame import LEAST
from core.mapping.injective.boundary_contact import BoundaryContacts
from core.mapping.injective.continuation import (
    FALL,
    FEW_STEPS,
    GENTLE_FALL,
    LIGHT,
    ROOMY,
    STEPS,
    clear_folds,
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
from core.mapping.tolerances import LITTLE, MET_PX, ROUNDING
from core.progress import Job

_COARSE, _FINER = 17.0, 0.67
"""Nodes of the coarse grid over the root of those of the fine one; its cells in a second attempt, over the first."""
_BESIDE = 40
"""Outline nodes either side of a cut that may glide or leave the outline."""


class Ways:
    """The ways from a linear answer that folds to a map that does not."""

    def __init__(self, mapping: FeatureMapping, level: GridLevel, linear: Map, goal: Goal, centres: Complexes) -> None:
        self._mapping, self._centres = mapping, centres
        self._level, self._linear, self._goal = level, linear, goal
        self._is_straight = bool(level.constraints.glide.any())
        """Whether all of the frame glides."""
        self._beside = nodes_beside_cuts(level.grid, level.index, _BESIDE)
        """Nodes (R, C) of another frame that may glide, but for corners, or leave the outline."""
        self._cells = max(1.0, level.grid.size**0.25 / _COARSE**0.5)
        self._refinement = Refinement(mapping, linear, goal, centres)

    def find(self, safe: Map | None, near: Map | None = None) -> Job[Map]:
        """Try one way after the other; what then still misses its targets is drawn there from a map without folds."""
        best: Map | None = None
        least = np.inf
        for way in self._in_order(safe, near):
            found = yield from way
            if found is None or count_folds(self._level, found.z):
                continue
            miss = float(misses(self._level, found.z).max(initial=0))
            if miss < least:
                best, least = found, miss
            if least < MET_PX:
                return found
        if best is None and safe is None:
            best = small(self._level, self._goal)
            if not self._is_straight or count_folds(self._level, best.z):
                return similar(self._level)
        return (yield from self._drawn(best, safe))

    def _in_order(self, safe: Map | None, near: Map | None) -> Iterator[Job[Map | None]]:
        level = self._level
        yield self._nearby(self._linear, FEW)
        if near is not None:
            yield self._nearby(posed(self._mapping, level, self._goal, near, self._centres), MANY)
            yield self._from_coarse(near)
        yield self._from_coarse(self._linear)
        if safe is not None:
            if not self._is_straight and self._beside.any() and not level.constraints.is_free:
                yield self._gliding(safe)
            return
        if not self._is_straight and self._beside.any():
            yield self._beside_cuts()
        yield self._from_coarse(self._linear, _FINER * self._cells)
        if self._is_straight:
            yield self._from_coarse(small(level, self._goal), far=True)
        else:
            yield self._from_similar()

    def _gliding(self, safe: Map) -> Job[Map | None]:
        """Show the way from what is `safe` as far as nothing folds; then let the outline glide beside cuts."""
        yield preview(self._level, part_of_the_way(self._level, safe, self._linear))
        return (yield from self._from_coarse(self._linear, glide=self._beside))

    def _beside_cuts(self) -> Job[Map | None]:
        """Let the outline go, beside cuts if that is enough, and show that; it is kept unless gliding is enough."""
        left = yield from self._from_coarse(self._linear, loose=self._beside)
        if left is None and any(body.limits.least > 0 for body in self._mapping.bodies[: len(self._linear.alpha)]):
            left = yield from self._smaller()
        if left is None:
            left = yield from self._from_similar()
        return (yield from self._from_coarse(self._linear, glide=self._beside)) or left

    def _from_similar(self) -> Job[Map | None]:
        """Draw sizes and outline to their goals from the one similarity of all that is closest to S."""
        return self._from_coarse(similar(self._level), loose=self._level.grid.outline, far=True)

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
        self,
        begin: Map,
        cells: float | None = None,
        *,
        glide: Bools | None = None,
        loose: Bools | None = None,
        far: bool = False,
    ) -> Job[Map | None]:
        """Find a map on a grid of larger cells, and refine that; outline nodes (R, C) may glide or be loose."""
        level = self._level
        if glide is not None:
            glide = glide.copy()
            glide[CORNERS] = False
            level = replace(level, constraints=replace(level.constraints, glide=glide))
        way = Transfer(level, max(1.0, cells or self._cells), held_outline=loose is None)
        freedoms = Freedoms(level.constraints.free[:, SCALE], loose=loose)
        problem = yield from self._on_coarse(way, begin, freedoms, far=far)
        if problem is None:
            return None
        is_small = (np.abs(problem.state.alpha) < LITTLE * self._goal.scales).any()
        if is_small and loose is None and not self._is_straight:
            return None
        return (yield from self._refinement.finish(way, problem))

    def _on_coarse(self, way: Transfer, begin: Map, freedoms: Freedoms, *, far: bool) -> Job[Problem | None]:
        """Clear folds on the coarse grid, and bring the map to its best there; None if folds are left.

        A map that is `far` from its goals begins without folds, or nearly: they are cleared before anything is drawn.
        """
        coarse, held, leaves = way.coarse, way.coarse.constraints, freedoms.loose is not None
        if not coarse.is_fit():
            return None
        contacts = BoundaryContacts.of(way.fine, coarse, held_outline=not leaves)
        if freedoms.loose is not None:
            freedoms = replace(freedoms, loose=way.around(freedoms.loose) & coarse.grid.outline.ravel())
        freedoms = replace(freedoms, yields=freedoms.yields & (coarse.counts() > 0))
        start = way.restrict_map(begin, held_outline=not (leaves and far))
        if far:
            alone = replace(coarse, constraints=replace(held, probes=held.probes[:0], to=held.to[:0]))
            cleared = Problem(alone, start, self._goal, contacts=contacts)
            if not (yield from clear_folds(cleared)):
                return None
            start = cleared.found
        problem = Problem(coarse, start, self._goal, freedoms, contacts=contacts)
        if far:
            yield from relax(problem, end=ROOMY if problem.is_driven else LIGHT, steps=STEPS, fall=GENTLE_FALL)
        elif (yield from clear_folds(problem)):
            yield from relax(problem)
        else:
            return None
        return problem

    def _smaller(self) -> Job[Map | None]:
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
        ways = Ways(self._mapping, level, linear, goal, self._centres)
        return (yield from ways._from_coarse(linear, loose=self._beside))

    def _drawn(self, near: Map | None, safe: Map | None) -> Job[Map]:
        """Draw handles, and the poses that they hold, towards their goals, as far as nothing folds.

        That begins at a map without folds: the one that is `near` or, where there is none, part of the way from `safe`.
        """
        level, start = self._level, near
        if start is None:
            assert safe is not None
            start = part_of_the_way(level, safe, self._linear)
            yield preview(level, start)
            way, freedoms = Transfer(level, self._cells, held_outline=True), self._driven(start)
            coarse = yield from self._on_coarse(way, start, freedoms, far=True)
            if coarse is not None and not coarse.crosses_itself(coarse.state):
                lifted, held = way.prolong_map(coarse.found), replace(freedoms, moves=False)
                start = part_of_the_way(level, start, (yield from self._refinement.clear_lifted(level, lifted, held)))
        problem = Problem(level, start, self._goal, self._driven(start))
        yield from relax(problem, fall=FALL**0.5)
        return problem.found

    def _driven(self, start: Map) -> Freedoms:
        """Return what is drawn to its goal from a map where it is not there yet: points, and poses that are held."""
        held, goal = self._level.constraints, self._goal
        turned, shifted = np.log(start.alpha / goal.alpha), start.place - goal.place
        away = np.stack([turned.real, turned.imag, shifted.real, shifted.imag], axis=1)
        driven = ~held.free & (np.abs(away) > ROUNDING)
        return Freedoms((held.free | driven)[:, SCALE], driven=driven)
