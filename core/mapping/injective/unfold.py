"""A map without folds, as close to what is wanted as its features, handles and frame allow.

FAT sec. 5 leaves fold-overs as future work. Here one problem is solved, by one stepper, along one continuation.

**Unknowns.** Nodes of the grid lie at z, complex, in pixels. Nodes of body i lie at z = t + α (p - pivot), where p is
their place in the picture and α = α⁰ exp(ρ + iφ): they are eliminated, so that bodies keep their shape exactly. Unknown
are inner nodes (2 each), of every body those of ρ, φ, Re t and Im t that the constraints leave free, and by their arc
length nodes of the outline that glide along it (`unknowns`).

**Energy**, in units of a cell:

    E = ½ Σ_quads Σ_edges w_W² |dz - dW|² + w_F² |dz - α dp|²      FAT eq. 4 for the background, eq. 3 around bodies
      + μ Σ_corners [|J|² + 1 + D²] / (2 χ_ε(D))                   against folds, Garanzha et al. 2021 (`barrier`)
      + Σ_bodies k n_i δ h(log(|α_i| / s_i) / δ)                   sizes s_i, by n_i nodes
      + Σ_loose τ δ h(|z - S| / δ)                                 the outline of S, where it may be left
      + Σ_driven ν δ h(distance / δ)                               handles, where they cannot be held

J is a corner's linear map against the same corner of S (`shape`), a map without folds, and D its determinant. W is what
is `wanted`; it may fold. h grows like a line (`springs`): sizes, outline and handles behave as with friction. They stay
where the force on them is below their strength, and what stayed is then set exactly. Strengths say what yields first:
the background, then sizes, then the outline, at last handles, those first that are farthest from what can be had. The
shape of a body never yields, and nothing ever folds.

**Constraints**, hard: the bilinear places of points of the background lie on their targets, C z = to. A step satisfies
them to first order, C step = to - C z, and the line search minds how far they are from being met (`newton`).

**Continuation** (`continuation`). Folds are cleared from the linear answer, which meets all constraints but folds in
places: ε falls from the depth of the folds with μ large, until every corner has room. Where they do not become
shallower, friction falls; then μ rises. After that μ falls, and with it ε, while the line search keeps D positive.

**Coarse to fine** (`levels`, `refinement`). Both run first on a grid of larger cells, on all of it. Corners of the fine
grid that poses alone decide stand behind the coarse barrier as well (`contacts`). What friction held is set exactly;
the result is lifted, and the few folds that come of it are cleared in narrow windows: the first map without folds.
Elsewhere the linear answer for these poses takes its place, and near folds E is brought to its least.

**Order of ways.** Few folds are cleared on the fine grid at once, outline and sizes held. From a map that is `near`,
where one is given, more of them are, with bodies as there. Then the coarse grid has its turn with the outline where it
is, first from that map; then with outline nodes beside cut bodies gliding along it, or, failing that, leaving it, rigid
bodies at the size they have under W if that is no less than half. At last the way begins at a map without folds
(`safe`: the picture before a handle moved, else the one similarity of all closest to S, or S with small bodies in it;
`starts`) and handles, sizes and outline are drawn to their goals; what does not get there stays where it came to. What
cannot be lifted from there is lifted from where all corners still had room. All loops are bounded by counts.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import count

import numpy as np

from core.arrays import Floats
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.pose import Solution
from core.mapping.folds import find_folded_quads
from core.mapping.handles.constraints import SCALE, Constraints
from core.mapping.handles.curved_frame import LEAST
from core.mapping.injective.boundary_contact import BoundaryContacts
from core.mapping.injective.continuation import (
    FEW_STEPS,
    GENTLE_FALL,
    GENTLE_STEPS,
    LIGHT,
    ROOM,
    ROOMY,
    clear_folds,
    is_met,
    relax,
)
from core.mapping.injective.levels import GridLevel, Map, Transfer
from core.mapping.injective.outline import CORNERS, nodes_beside_cuts
from core.mapping.injective.problem import Goal, Problem
from core.mapping.injective.refinement import REACH, Refinement, preview
from core.mapping.injective.starts import part_of_the_way, posed, similar, small
from core.mapping.injective.unknowns import Freedoms
from core.mapping.injective.windows import MET, count_folds, misses, window_around
from core.mapping.jacobians import Complexes, as_complex
from core.progress import Job, T, stepwise

_FEW, _MANY = 20, 200
"""Folds that are cleared on the fine grid at once; with bodies as they are in a map nearby."""
_COARSE, _FINER = 17.0, 0.67
"""Nodes of the coarse grid over the root of those of the fine one; its cells in a second attempt, over the first."""
_BESIDE = 40
"""Outline nodes either side of a cut that may glide or leave the outline."""
_WORTH = 0.1
"""Share of its size that a body is to keep before the outline gives way."""
_SAME = 1e-9
"""Logarithm of a scale, angle, or pixels that a held freedom may be off without being drawn to its goal."""
_WIDER = 3
"""Points that cannot be brought to their targets in a narrow window are tried in one so many times wider."""
_PACE = 0.98
"""What a step leaves of the work that is said to be left."""


def unfold(
    mapping: FeatureMapping,
    wanted: Complexes,
    start: Solution,
    *,
    shape: Complexes,
    scales: Floats,
    constraints: Constraints,
    safe: Solution | None = None,
    near: Solution | None = None,
) -> Job[Solution]:
    """Return a map without folded quads that is as close to what is wanted as that allows.

    Parameters
    ----------
    mapping
        The grid with its bodies and the roles of its quads; it is left as it was.
    wanted
        W (R, C), which background quads follow.
    start
        The linear answer, which meets all constraints but may fold.
    shape
        S (R, C), a map without folds that corners are measured against, and whose outline is kept.
    scales
        Size (n,) that each body is to have.
    safe
        A map without folds with exact bodies, from which handles can be drawn to their goals.
    near
        A map without folds of nearly the same, such as the frame before: of several maps, the one next to it is found.

    A step's preview is a first map without folds, (R, C, 2), on which the rest of the work improves. Where `shape`
    folds, or no way succeeds and there is nothing safe, the linear answer is returned.
    """
    if find_folded_quads(shape).any() or not find_folded_quads(start.z).any():
        return start
    n, rest = len(start.alpha), as_complex(mapping.grid.nodes).ravel()
    centres = np.array([rest[body.nodes].mean() for body in mapping.bodies[:n]], np.complex128)
    order = np.lexsort((constraints.to.imag, constraints.to.real, *constraints.probes.at.T))
    held = replace(constraints, probes=constraints.probes[order], to=constraints.to[order])
    if not n:
        held = replace(held, pivots=held.pivots[:0], free=held.free[:0])
    level = GridLevel.of(mapping, wanted, start, shape, held)
    linear = level.of_solution(start, centres)
    begin, beside = (None if known is None else level.of_solution(known, centres) for known in (safe, near))
    ways = Ways(mapping, level, linear, Goal(scales[:n], linear.alpha, linear.place), centres)
    found = yield from _counted(ways.find(begin, beside))
    return start if found is None else level.solution_of(found, centres)


def _counted(job: Job[T]) -> Job[T]:
    """Run `job` with fractions that grow with every step, since nobody knows how many there will be."""
    counter = count(1)
    return stepwise(job, lambda step: replace(step, fraction=1 - _PACE ** next(counter)))


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
            if least < MET:
                break
        if best is safe and safe is not None:
            return part_of_the_way(self._level, safe, self._linear)
        return best if best is None or not MET < least < np.inf else (yield from self._brought_home(best))

    def _brought_home(self, found: Map) -> Job[Map]:
        """Return a map without folds with points that are not on their targets brought there, if that folds nothing."""
        level = self._level
        for reach in (REACH, _WIDER * REACH):
            window = window_around(level, found.z, reach, bodies=reach > REACH)
            problem = Problem(level, found, window, self._goal, Freedoms(np.zeros(len(found.alpha), bool)))
            yield from relax(problem, steps=GENTLE_STEPS)
            if is_met(problem) and not count_folds(level, problem.found.z):
                return problem.found
        return found

    def _in_order(self, safe: Map | None, near: Map | None) -> Iterator[Job[Map | None]]:
        level = self._level
        cells = max(1.0, level.grid.size**0.25 / _COARSE**0.5)
        yield self._nearby(self._linear, _FEW)
        if near is not None:
            yield self._nearby(posed(self._mapping, level, self._goal, near, self._centres), _MANY)
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
        if left is None and safe is None and self._mapping.keep == "rigid":
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
        window = window_around(level, start.z, REACH)
        problem = Problem(level, start, window, self._goal, Freedoms(np.zeros(len(start.alpha), bool)))
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
        everywhere = np.ones(coarse.grid.size, bool)
        freedoms = Freedoms(yields, loose=beside)
        start = way.restrict_map(self._linear if begin is None else begin)
        problem = Problem(coarse, start, everywhere, self._goal, freedoms, contacts)
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
        driven = ~held.free & (np.abs(away) > _SAME)
        yields = (held.free | driven)[:, SCALE] & (coarse.counts() > 0)
        everywhere, outline = np.ones(coarse.grid.size, bool), coarse.grid.outline.ravel()
        contacts = BoundaryContacts.of(level, coarse, held_outline=not leaves)
        freedoms = Freedoms(yields, loose=outline if leaves else None, driven=driven)
        begin = way.restrict_map(start, held_outline=not leaves)
        alone = replace(coarse, constraints=replace(coarse.constraints, probes=held.probes[:0], to=held.to[:0]))
        cleared = Problem(alone, begin, everywhere, goal, Freedoms(np.zeros_like(yields)), contacts)
        if not (yield from clear_folds(cleared)):
            return None
        problem = Problem(coarse, cleared.found, everywhere, goal, freedoms, contacts)
        end = ROOMY if len(held.probes) or driven.any() else LIGHT
        roomy = problem.state
        for step in relax(problem, end=end, steps=GENTLE_STEPS, fall=GENTLE_FALL):
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
        alpha = sizes * np.exp(1j * np.angle(alpha))
        linear = level.of_solution(self._mapping.place_at(level.wanted, alpha, t), self._centres)
        goal = Goal(sizes, linear.alpha, linear.place)
        return (
            yield from Ways(self._mapping, level, linear, goal, self._centres)._from_coarse(level, cells, leaves=True)
        )
