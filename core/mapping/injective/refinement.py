"""From a map of the coarse grid without folds to the best one of the fine grid."""

from dataclasses import replace

import numpy as np

from core.arrays import Bools, Ints
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.handles.constraints import SCALE
from core.mapping.injective.continuation import FEW_STEPS, HEAVY, clear_folds, is_met, relax
from core.mapping.injective.levels import GridLevel, Map, Transfer
from core.mapping.injective.problem import Goal, Problem
from core.mapping.injective.springs import SLACK
from core.mapping.injective.unknowns import Freedoms, Iterate
from core.mapping.injective.windows import (
    around,
    count_folds,
    misses,
    nearness,
    widen,
    window_around,
    wrong_nodes,
)
from core.mapping.jacobians import Complexes, as_positions
from core.mapping.tolerances import LITTLE
from core.progress import Job, Progress

CLOSE, REACH = 5, 12
"""Cells around folds that may move first, and around folds, and bodies there, that may move then."""
_LEAST = 1e-3
"""Share of its area that a corner is to have when sizes are set exactly, if it has twice that before."""
_BLENDS = (9, 36, 72)
"""Cells around folds of the smooth map over which what was found goes over into it."""
FEW, MANY = 20, 200
"""Folds that are cleared in windows of the fine grid: all of them at once, and beside bodies that stay."""
_LAST_STEPS, _GROWING_STEPS = 4, 16
"""Steps to the least of E on the fine grid, and where sizes that gave way have to grow back."""


class Refinement:
    """The way back from a coarse grid for `linear`, the fine grid's map that folds; `centres` (n,) are of bodies."""

    def __init__(self, mapping: FeatureMapping, linear: Map, goal: Goal, centres: Complexes) -> None:
        self._mapping, self._linear, self._goal, self._centres = mapping, linear, goal, centres

    def finish(self, way: Transfer, problem: Problem) -> Job[Map | None]:
        """Set exactly what friction held, lift the map, clear what folds then, and bring it to its best.

        None if folds are left, or if points that the coarse grid does not hold are too far off for narrow windows.
        """
        level = way.fine
        problem, yields = yield from self._settle(problem)
        found = way.prolong_map(problem.found)
        if misses(level, found.z).max(initial=0) > CLOSE * level.side:
            return None
        loose = level.off_outline(found.z)
        found = yield from self.clear_lifted(level, found, Freedoms(yields, loose=loose))
        if count_folds(level, found.z):
            return None
        yield preview(level, found)
        return (yield from self._improve(way, level, found, problem.found, Freedoms(yields, loose=loose)))

    def _settle(self, p: Problem) -> Job[tuple[Problem, Bools]]:
        """Set exactly, and hold, what friction held, if that folds nothing; return the problem and what gave way."""
        loose = p.unknowns.loose
        back = loose[np.abs(p.outline_changes(p.state)) < SLACK]
        for limit in (LITTLE, SLACK):
            start, gave = _set_exactly(p, limit, back)
            if _is_allowed(p, start):
                p.state = start
                return p, gave
            left = np.isin(np.arange(p.level.grid.size), np.setdiff1d(loose, back))
            begin = Map(start.z[: len(left)], start.alpha, start.place)
            q = Problem(p.level, begin, self._goal, Freedoms(gave, loose=left), contacts=p.contacts)
            if (yield from clear_folds(q, FEW_STEPS)):
                yield from relax(q, HEAVY / 10)
                return q, gave
        return p, p.unknowns.yields

    def clear_lifted(self, level: GridLevel, found: Map, freedoms: Freedoms) -> Job[Map]:
        """Return a map that a coarse grid was lifted to with fewer folds, from ever wider windows around them.

        At last bodies move as well, if they may.
        """
        for reach, moves in ((CLOSE, False), (REACH, False), *([(REACH, True)] if freedoms.moves else [])):
            found = yield from self._clear(level, found, reach, replace(freedoms, moves=moves))
        return found

    def _clear(self, level: GridLevel, found: Map, reach: int, freedoms: Freedoms) -> Job[Map]:
        """Return the map with fewer folds, from windows around them and around points that are held off their targets.

        Where bodies move, any size may give way.
        """
        wrong = wrong_nodes(level, found.z, points=freedoms.driven is None)
        if not wrong.any():
            return found
        if freedoms.moves:
            freedoms = replace(freedoms, yields=freedoms.yields | level.constraints.free[:, SCALE])
        window = around(level, wrong, reach, bodies=freedoms.moves)
        problem = Problem(level, found, self._goal, freedoms, window=window)
        before = problem.count_folds()
        yield from clear_folds(problem)
        return problem.found if problem.count_folds() <= before else found

    def _improve(self, way: Transfer, level: GridLevel, found: Map, coarse: Map, freedoms: Freedoms) -> Job[Map]:
        """Bring a map without folds to the least of E, near where the smooth map with its poses folds.

        Where that cannot be told, everywhere.
        """
        window, mu = np.ones(level.grid.size, bool), HEAVY / 100
        loose = np.zeros_like(window) if freedoms.loose is None else freedoms.loose
        smooth = self._smooth(way, level, found, coarse, leaves=bool(loose.any()))
        wrong = wrong_nodes(level, smooth.z) | loose
        for reach in _BLENDS:
            share = nearness(level, wrong, reach) if wrong.any() else np.zeros(len(wrong))
            mixed = replace(smooth, z=smooth.z + share * (found.z - smooth.z))
            if count_folds(level, mixed.z) < FEW:
                break
        if 0 < count_folds(level, mixed.z) < MANY:
            mixed = yield from self._clear(level, mixed, CLOSE, replace(freedoms, moves=False))
        if not count_folds(level, mixed.z):
            near = window_around(level, smooth.z, REACH) | widen(level, loose, REACH) | (share > 0)
            found, window, mu = mixed, near | widen(level, wrong_nodes(level, mixed.z), CLOSE), HEAVY / 10
        problem = Problem(level, found, self._goal, freedoms, window=window)
        if not problem.unknowns.yields.any():
            yield from relax(problem, mu, steps=_LAST_STEPS)
            return problem.found
        yield from relax(problem, mu, steps=_GROWING_STEPS)
        for limit in (LITTLE, SLACK):
            exact, _ = _set_exactly(problem, limit, problem.unknowns.loose[:0])
            if _is_allowed(problem, exact):
                problem.state = exact
                break
        return problem.found

    def _smooth(self, way: Transfer, level: GridLevel, found: Map, coarse: Map, *, leaves: bool) -> Map:
        """Return the map that the poses found would have if nothing kept it from folding.

        Without handles and with the outline where it was, it is the linear answer for these poses; else the linear
        answer for its own, with what the coarse grid changed of that.
        """
        held = level.constraints
        if len(held.probes) or held.glide.any() or leaves or not np.array_equal(level.wanted, level.shape):
            change = way.prolong(coarse.z - way.restrict(self._linear.z))
            z = np.where(level.grid.outline.ravel(), found.z, self._linear.z + change)
            return level.placed(z, found.alpha, found.place)
        solution = level.solution_of(found, self._centres)
        return replace(found, z=self._mapping.place_at(level.wanted, solution.alpha, solution.t).z.ravel())


def _set_exactly(p: Problem, limit: float, back: Ints) -> tuple[Iterate, Bools]:
    """Return the state with sizes exact that changed by less than `limit`, `back` on the outline; and who yields."""
    bodies, change = p.size_changes(p.state)
    near = bodies[np.abs(change) < limit]
    z, alpha = p.state.z.copy(), p.state.alpha.copy()
    alpha[near] *= p.goal.scales[near] / np.abs(alpha[near])
    z[back] = p.level.shape.ravel()[back]
    gave = p.unknowns.yields.copy()
    gave[near] = False
    return p.unknowns.moved(replace(p.state, z=z, alpha=alpha), np.zeros(p.unknowns.count)), gave


def _is_allowed(p: Problem, state: Iterate) -> bool:
    """Return whether a state folds nothing, nor all but folds it, and has all held points on their targets."""
    least = min(_LEAST, p.worst() / 2)
    kept, p.state = p.state, state
    allowed = p.worst() > max(least, 0.0) and is_met(p)
    p.state = kept
    return allowed


def preview(level: GridLevel, found: Map) -> Progress:
    """Return the step that shows a map without folds."""
    return Progress(0.0, "unfolding", as_positions(found.z.reshape(level.grid.shape)))
