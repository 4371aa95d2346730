"""Newton's method on a mapping: until nothing is folded, and then back towards W."""

from typing import Literal

import cv2
import numpy as np

from core.arrays import Bools, Floats
from core.mapping.distortion import Barrier, Hinge
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.folds import folded_quads
from core.mapping.frames import Complexes
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
_BLEND = 0.9


def steps_to_clear(untangler: Untangler, kind: Kind, steps: int) -> Job[bool]:
    """Take Newton steps until nothing is folded; return whether that was reached."""
    seen: list[float] = []
    epsilon = np.inf
    for step in range(steps):
        worst = untangler.worst
        if worst > 0:
            return True
        if len(seen) >= _PATIENCE and worst < _BETTER * seen[-_PATIENCE]:
            break
        seen.append(worst)
        epsilon = max(_SHARP, min(float(np.hypot(_SHARP, _LAG * worst)), _FALL * epsilon))
        if kind == "hinge":
            moved = untangler.step(Hinge(_KEPT), _HINGE_WEIGHT * _TIGHTEN**step)
        else:
            moved = untangler.step(Barrier(epsilon), _BARRIER_WEIGHT)
        if not moved:
            break
        yield Progress(step / steps, "unfolding")
    return untangler.worst > 0


def relaxed(untangler: Untangler) -> Solution:
    """Come closer to W without folding again, behind a barrier that becomes lighter."""
    clear = untangler.solution
    for weight in _LIGHTER:
        untangler.step(Barrier(_SHARP), weight)
        if untangler.worst <= _LEAST:
            break
        clear = untangler.solution
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
        yield Progress(step / steps, "unfolding")
    return clear


def blended(w: Complexes, solution: Solution) -> Solution:
    """Go from W towards a solution without bodies as far as nothing folds."""
    share = 1.0
    while folded_quads(z := w + share * (solution.z - w)).any():
        share = share * _BLEND if share > _LEAST else 0.0
    return Solution(z, solution.alpha, solution.t)


def window_around(mapping: FeatureMapping, solution: Solution, reach: int = REACH) -> Bools:
    """Return the nodes around folded quads, and around all features that come near them."""
    nodes = np.zeros(mapping.grid.shape, bool)
    for corner in (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, 1:], np.s_[1:, :-1]):
        nodes[corner] |= folded_quads(solution.z)
    window = widened(nodes, reach)
    near = np.unique(mapping.index[window & (mapping.index >= 0)])
    return window | widened(np.isin(mapping.index, near), reach)


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
