"""Remove fold-overs from a mapping, which FAT sec. 5 leaves as future work.

The cheap way first: quads that fold are drawn closer to W by the weight of their equations, which takes a factorisation
a round. What stays folded is untangled by Newton's method, in a window around the folds and then everywhere, quickly
and then robustly, if need be from W itself, which has no folds. Scales of features give way as little as they can; a
rigid feature's not at all unless it must.

There may be no mapping without folds: a straight side of a feature that the picture's edge cuts at both ends has to
pass between the outline nodes beside either cut, so it cannot go around an outline that W bends across that line. A
band across a picture that becomes half a ring is such a case. As the outline and the shape are both to be kept, quads
then stay folded.
"""

import copy
from typing import Literal

import cv2
import numpy as np

from core.arrays import Bools, Floats
from core.mapping.distortion import Barrier, Hinge
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.folds import corner_areas, folded_quads
from core.mapping.frames import Complexes
from core.mapping.junctions import fit_between
from core.mapping.stiffen import stiffen
from core.mapping.untangle import Untangler
from core.progress import Job, Progress, part

_ROUNDS = 2
_THIN = 0.15
"""A corner with less than this share of its area under W is about to fold."""
_GAIN = 8.0
_REACH = 12
"""Cells around what folds that may move at first."""
_KEPT = 0.3
"""Share of its area that the hinge asks of a corner, enough to leave none at zero."""
_HINGE_WEIGHT, _TIGHTEN = 1e4, 1.5
_BARRIER_WEIGHT, _LIGHTER = 100.0, (10.0, 1.0, 0.3, 0.1)
_LEAST = 1e-4
"""Share of its area that a corner has at least in the end."""
_SHARP = 1e-3
_LAG = 0.2
"""ε of the barrier over the depth of the worst fold."""
_TRIALS = 3
_PATIENCE, _BETTER = 10, 0.95
"""Attempts end that have not made the worst fold this much shallower in so many steps."""
_BLEND = 0.9
_NEARLY, _EXACT = 0.02, 1e-9
"""Logarithms of scales that are as good as one, and that are one."""
_STIFF, _SOFT = 20.0, 0.5
"""Stiffness of a feature's scale, per node."""


_Attempt = tuple[Bools, Floats | None, Literal["hinge", "barrier"], int]
"""Window, stiffness, penalty, steps."""
_FROM_W = None
"""The attempt that starts from W instead of from the best state so far."""


def unfold(mapping: FeatureMapping, w: Complexes) -> Job[Solution]:
    """Return a mapping without folded quads, if W has none; the mapping object is left as it was.

    Should nothing help, the result is the one with the fewest folded quads.
    """
    linear = mapping.place(w)
    if folded_quads(w).any() or not folded_quads(linear.z).any():
        return linear
    yield Progress(0.0, "unfolding", linear.positions)
    solution = fit_between(mapping, w, linear)
    if solution is None:
        solution = yield from _reweighted(mapping, w)
        if folded_quads(solution.z).any():
            solution = yield from _untangled(mapping, w, linear, fitted=False)
    elif folded_quads(solution.z).any():
        solution = yield from _untangled(mapping, w, solution, fitted=True)
    if mapping.keep == "rigid" and mapping.method == "exact":
        if folded_quads(solution.z).any():
            solution = yield from part(_resized_freely(mapping, w, solution), 0.8, 0.8)
        solution = yield from _grown(mapping, w, solution)
    return solution


def _resized_freely(mapping: FeatureMapping, w: Complexes, folded: Solution) -> Job[Solution]:
    """Return the mapping whose features take the size they have under W, if that one does not fold."""
    similar = copy.copy(mapping)
    similar.keep = "similarity"
    found = yield from unfold(similar, w)
    return folded if folded_quads(found.z).any() else found


def _reweighted(mapping: FeatureMapping, w: Complexes) -> Job[Solution]:
    """Raise the weight of FAT eq. 4 around what folds or is about to, and solve again, a few times over."""
    follow_w, areas = mapping.follow_w, corner_areas(w)
    solution = mapping.place(w)
    try:
        for step in range(_ROUNDS):
            thin = np.asarray((corner_areas(solution.z) < _THIN * areas).any(axis=0))
            near = _widened(thin, 2)
            mapping.factorise(np.where(near, _GAIN * (1 + mapping.follow_w), mapping.follow_w))
            solution = mapping.place(w)
            yield Progress(0.1 * (step + 1) / _ROUNDS, "unfolding", solution.positions)
            if not folded_quads(solution.z).any():
                break
    finally:
        mapping.factorise(follow_w)
    return solution


def _untangled(mapping: FeatureMapping, w: Complexes, start: Solution, *, fitted: bool) -> Job[Solution]:
    """Untangle in ever wider and softer attempts, each from the best state so far, then come back closer to W."""
    nodes = np.array([len(body.nodes) for body in mapping.bodies], np.float64)[: len(start.alpha)]
    stiff = np.full(len(nodes), np.inf) if mapping.keep == "rigid" else _STIFF * nodes
    window, everywhere = _window(mapping, start), np.ones(mapping.grid.shape, bool)
    attempts: list[_Attempt | None] = [(window, None, "barrier", 40)] if fitted else [(window, stiff, "hinge", 12)]
    attempts += [(window, stiff, "barrier", 40), _FROM_W, (everywhere, stiff, "barrier", 40)]
    attempts += [(everywhere, _STIFF * nodes, "barrier", 30), (everywhere, _SOFT * nodes, "barrier", 40)]
    best = start
    for number, attempt in enumerate(attempts):
        first, last = (0.1 + 0.7 * n / len(attempts) for n in (number, number + 1))
        if attempt is None:
            stiffened = yield from part(_from_w(mapping, w, best), first, last)
            if stiffened is not None:
                return stiffened
            continue
        where, stiffness, kind, steps = attempt
        untangler = Untangler(mapping, w, best, window=where, stiffness=stiffness)
        clear = yield from part(_steps(untangler, kind, steps), first, last)
        if clear or untangler.folds < folded_quads(best.z).sum():
            best = untangler.solution
        if clear:
            return _relaxed(Untangler(mapping, w, best, window=where, stiffness=stiff), best)
    return best


def _from_w(mapping: FeatureMapping, w: Complexes, best: Solution) -> Job[Solution | None]:
    """Start from W, which has no folds; None if features do not fit."""
    if not len(best.alpha):
        return _blended(w, best)
    scales = np.abs(mapping.place(w).alpha)
    clear = yield from stiffen(mapping, w, scales)
    if clear is None:
        return None
    everywhere = np.ones(mapping.grid.shape, bool)
    return _relaxed(Untangler(mapping, w, clear, window=everywhere, stiffness=np.ones(len(scales))), clear)


def _blended(w: Complexes, solution: Solution) -> Solution:
    """Go from W towards a solution without bodies as far as nothing folds."""
    share = 1.0
    while folded_quads(z := w + share * (solution.z - w)).any():
        share = share * _BLEND if share > _LEAST else 0.0
    return Solution(z, solution.alpha, solution.t)


def _steps(untangler: Untangler, kind: str, steps: int) -> Job[bool]:
    """Take Newton steps until nothing is folded; return whether that was reached."""
    seen: list[float] = []
    for step in range(steps):
        worst = untangler.worst
        if worst > 0:
            return True
        if len(seen) >= _PATIENCE and worst < _BETTER * seen[-_PATIENCE]:
            break
        seen.append(worst)
        if kind == "hinge":
            moved = untangler.step(Hinge(_KEPT), _HINGE_WEIGHT * _TIGHTEN**step)
        else:
            moved = untangler.step(Barrier(float(np.hypot(_SHARP, _LAG * worst))), _BARRIER_WEIGHT)
        if not moved:
            break
        yield Progress(step / steps, "unfolding")
    return untangler.worst > 0


def _relaxed(untangler: Untangler, clear: Solution) -> Solution:
    """Come closer to W without folding again, behind a barrier that becomes lighter."""
    for weight in _LIGHTER:
        untangler.step(Barrier(_SHARP), weight)
        if untangler.worst <= _LEAST:
            break
        clear = untangler.solution
    return clear


def _grown(mapping: FeatureMapping, w: Complexes, solution: Solution) -> Job[Solution]:
    """Bring rigid features back to the largest sizes that fit."""
    lost = np.log(np.abs(solution.alpha))
    if np.abs(lost).max(initial=0.0) < _EXACT:
        return solution
    low, high = 0.0, 1.0
    for number in range(_TRIALS):
        share = high if number == 0 else (low + high) / 2
        trial = _resized(mapping, solution, np.where(np.abs(lost) < _NEARLY, -lost, -lost * share))
        held = np.full(len(lost), np.inf)
        untangler = Untangler(mapping, w, trial, window=_window(mapping, trial), stiffness=held)
        start, end = (0.8 + 0.2 * n / _TRIALS for n in (number, number + 1))
        clear = yield from part(_steps(untangler, "barrier", 25), start, end)
        if clear:
            low, best = share, untangler.solution
            if share == 1:
                break
        else:
            high = share
    return solution if low == 0 else best


def _resized(mapping: FeatureMapping, solution: Solution, logarithms: Floats) -> Solution:
    """Scale every feature about its centre."""
    z, alpha = solution.z.copy(), solution.alpha * np.exp(logarithms)
    for body, a, t in zip(mapping.bodies, alpha, solution.t, strict=True):
        z.ravel()[body.nodes] = body.place(a, t)
    return Solution(z, alpha, solution.t)


def _window(mapping: FeatureMapping, solution: Solution) -> Bools:
    """Return the nodes around folded quads, and around all features that come near them."""
    nodes = np.zeros(mapping.grid.shape, bool)
    for corner in (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, 1:], np.s_[1:, :-1]):
        nodes[corner] |= folded_quads(solution.z)
    window = _widened(nodes, _REACH)
    near = np.unique(mapping.index[window & (mapping.index >= 0)])
    return window | _widened(np.isin(mapping.index, near), _REACH)


def _widened(quads: Bools, reach: int) -> Bools:
    size = 2 * reach + 1
    return np.asarray(cv2.dilate(quads.astype(np.uint8), np.ones((size, size), np.uint8)) > 0)
