"""Newton's method on a mapping: until nothing is folded, and then back towards W."""

from typing import Literal

import cv2
import numpy as np

from core.arrays import Bools, Floats
from core.mapping.distortion import Barrier, Hinge
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.folds import folded_quads
from core.mapping.frames import Complexes
from core.mapping.release import around, crosses_itself
from core.mapping.untangle import Untangler
from core.progress import Job, Progress

Kind = Literal["hinge", "barrier"]

REACH = 12
"""Cells around what folds that may move."""
STEPS = 16
"""Newton steps to clear what folds, at most."""
_KEPT = 0.3
"""Share of its area that the hinge asks of a corner, enough to leave none at zero."""
_HINGE_WEIGHT, _TIGHTEN = 1e4, 1.5
_BARRIER_WEIGHT, _LIGHTER = 100.0, (10.0, 1.0, 0.3, 0.1)
_GROWING, _STILL = 0.5, 0.1
"""Factor of the barrier's weight a step, and a move, in cells, that is not worth another step."""
_LEAST = 1e-4
"""Share of its area that a corner has at least in the end."""
_SHARP = 1e-3
_LAG, _FALL = 0.2, 0.9
"""ε of the barrier over the depth of the worst fold, and over the last ε at most."""
_PATIENCE, _BETTER = 10, 0.95
"""Attempts end that have not made the worst fold this much shallower in so many steps."""
_GLANCE, _FADING, _DEEP = 4, 0.75, 0.2
"""Steps from which the rate is told; share of the folds that is left while they fade; depth that is hopeless."""
_FEWER, _LARGE, _CLOSE = 4, 4000, 10
"""Folds that have become so many times fewer are tried on their own, where unknowns are many, in so narrow windows."""
_BLEND = 0.9


def steps_to_clear(untangler: Untangler, kind: Kind, steps: int) -> Job[bool]:
    """Take Newton steps until nothing is folded; return whether that was reached.

    Whenever few of the folds are left, they are tried on their own first.
    """
    seen: list[tuple[float, int]] = []
    epsilon, few = np.inf, untangler.folds // _FEWER
    for step in range(steps):
        worst, folds = untangler.worst, untangler.folds
        if worst > 0:
            return True
        if folds <= few and untangler.size > _LARGE:
            few = folds // _FEWER
            if (yield from _cleared_alone(untangler)):
                return True
        if _is_hopeless(seen, worst, folds, steps - step):
            break
        seen.append((worst, folds))
        epsilon = max(_SHARP, min(float(np.hypot(_SHARP, _LAG * worst)), _FALL * epsilon))
        if kind == "hinge":
            moved = untangler.step(Hinge(_KEPT), _HINGE_WEIGHT * _TIGHTEN**step)
        else:
            moved = untangler.step(Barrier(epsilon), _BARRIER_WEIGHT)
        if not moved:
            break
        yield Progress(step / steps, "unfolding", work=untangler.size)
    if untangler.worst <= 0 and untangler.folds <= _FEWER * few and untangler.size > _LARGE:
        return (yield from _cleared_alone(untangler))
    return untangler.worst > 0


def _is_hopeless(seen: list[tuple[float, int]], worst: float, folds: int, steps: int) -> bool:
    """Return whether the folds, at the rate of the last steps, will still be deep after `steps` more."""
    if len(seen) >= _PATIENCE and worst < _BETTER * seen[-_PATIENCE][0]:
        return True
    if len(seen) < 2 * _GLANCE:
        return False
    before, many = seen[-_GLANCE]
    return folds > _FADING * many and worst * (worst / before) ** (steps / _GLANCE) < -_DEEP


def _cleared_alone(untangler: Untangler) -> Job[bool]:
    """Clear what is folded in small windows, features held where they are; return whether that was reached."""
    window = folds_widened(untangler.solution, _CLOSE)
    alone = Untangler(untangler.mapping, untangler.w, untangler.solution, window=window, stiffness=None)
    yield from steps_to_clear(alone, "barrier", STEPS)
    if alone.worst > untangler.worst and alone.folds < untangler.folds:
        untangler.z = alone.z
    return untangler.worst > 0


def relaxed(untangler: Untangler) -> Job[Solution]:
    """Come closer to W without folding again, behind a barrier that becomes lighter."""
    clear = untangler.solution
    yield Progress(0.0, "unfolding", clear.positions)
    for number, weight in enumerate(_LIGHTER):
        untangler.step(Barrier(_SHARP), weight)
        if untangler.worst <= 0 and not (yield from _cleared_alone(untangler)):
            break
        clear = untangler.solution
        yield Progress(number / len(_LIGHTER), "unfolding", work=untangler.size)
    return clear


def approached(
    untangler: Untangler, clear: Solution, steps: int, *, weight: float = _LIGHTER[0], lightest: float = _LIGHTER[-1]
) -> Job[Solution]:
    """Take Newton steps towards W behind a barrier that becomes lighter, as long as they lead on and nothing folds."""
    for step in range(steps):
        moved = untangler.step(Barrier(_LEAST), weight)
        if untangler.worst <= _LEAST:
            break
        before, clear = clear, untangler.solution
        still = np.abs(clear.z - before.z).max() < _STILL * untangler.side
        if weight <= lightest and (still or not moved):
            break
        weight = max(weight * _GROWING, lightest)
        yield Progress(step / steps, "unfolding", work=untangler.size)
    return clear


def blended(w: Complexes, solution: Solution) -> Solution:
    """Go from W towards a solution without bodies as far as nothing folds."""
    share = 1.0
    while folded_quads(z := w + share * (solution.z - w)).any():
        share = share * _BLEND if share > _LEAST else 0.0
    return Solution(z, solution.alpha, solution.t)


def placed(mapping: FeatureMapping, solution: Solution, alpha: Complexes, t: Complexes) -> Solution:
    """Give features other similarities; free nodes stay where they are."""
    z = solution.z.copy()
    for body, a, b in zip(mapping.bodies, alpha, t, strict=True):
        z.ravel()[body.nodes] = body.place(a, b)
    return Solution(z, alpha, t)


def window_around(mapping: FeatureMapping, solution: Solution, reach: int = REACH) -> Bools:
    """Return the nodes around folded quads, and around all features that come near them."""
    window = folds_widened(solution, reach)
    near = np.unique(mapping.index[window & (mapping.index >= 0)])
    return window | widened(np.isin(mapping.index, near), reach)


def folds_widened(solution: Solution, reach: int) -> Bools:
    """Return the nodes (R, C) within `reach` rows and columns of folded quads."""
    nodes = np.zeros(solution.z.shape, bool)
    for corner in (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, 1:], np.s_[1:, :-1]):
        nodes[corner] |= folded_quads(solution.z)
    return widened(nodes, reach)


def widened(quads: Bools, reach: int) -> Bools:
    """Return what lies within `reach` rows and columns of what is marked."""
    size = 2 * reach + 1
    return np.asarray(cv2.dilate(quads.astype(np.uint8), np.ones((size, size), np.uint8)) > 0)


def node_counts(mapping: FeatureMapping, solution: Solution) -> Floats:
    """Return how many nodes each body of the solution has."""
    return np.array([len(body.nodes) for body in mapping.bodies[: len(solution.alpha)]], np.float64)


def count_folds(solution: Solution) -> int:
    """Return the number of folded quads."""
    return int(folded_quads(solution.z).sum())


def is_clear(mapping: FeatureMapping, w: Complexes, z: Complexes) -> bool:
    """Return whether nothing folds, and the outline does not cross itself unless W has it so."""
    ring = around(mapping.grid)
    crossed = crosses_itself(z.ravel()[ring]) and not crosses_itself(w.ravel()[ring])
    return not crossed and not folded_quads(z).any()
