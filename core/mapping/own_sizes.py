"""Give rigid features that unfolding has made larger or smaller their own sizes back, as far as they fit."""

import numpy as np

from core.arrays import Floats
from core.mapping.approach import STEPS, steps_to_clear, window_around
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.frames import Complexes
from core.mapping.untangle import Untangler
from core.progress import Job, part

_TRIALS = 3
EXACT = 1e-9
"""Logarithm of a scale that is one."""
_NEARLY = 0.03
"""Logarithm of a scale that is as good as one."""


def bisected(mapping: FeatureMapping, w: Complexes, solution: Solution) -> Job[Solution]:
    """Bring rigid features that gave way a little back to the largest sizes that fit, all by the same share."""
    lost = np.log(np.abs(solution.alpha))
    best, low, high = solution, 0.0, 1.0
    for number in range(_TRIALS):
        share = high if number == 0 else (low + high) / 2
        trial = _resized(mapping, solution, np.where(np.abs(lost) < _NEARLY, -lost, -lost * share))
        held = np.full(len(lost), np.inf)
        untangler = Untangler(mapping, w, trial, window=window_around(mapping, trial), stiffness=held)
        start, end = (n / _TRIALS for n in (number, number + 1))
        clear = yield from part(steps_to_clear(untangler, "barrier", STEPS), start, end)
        if clear:
            low, best = share, untangler.solution
        if low == high:
            break
        high = high if clear else share
    return best


def snapped(mapping: FeatureMapping, w: Complexes, solution: Solution) -> Job[Solution]:
    """Give rigid features that nearly have their own size that size, if nothing folds."""
    lost = np.log(np.abs(solution.alpha))
    near = (np.abs(lost) < _NEARLY) & (np.abs(lost) > EXACT)
    if not near.any():
        return solution
    trial = _resized(mapping, solution, np.where(near, -lost, 0.0))
    held = np.full(len(lost), np.inf)
    untangler = Untangler(mapping, w, trial, window=window_around(mapping, trial), stiffness=held)
    clear = yield from steps_to_clear(untangler, "barrier", STEPS)
    return untangler.solution if clear else solution


def _resized(mapping: FeatureMapping, solution: Solution, logarithms: Floats) -> Solution:
    """Scale every feature about its centre."""
    z, alpha = solution.z.copy(), solution.alpha * np.exp(logarithms)
    for body, a, t in zip(mapping.bodies, alpha, solution.t, strict=True):
        z.ravel()[body.nodes] = body.place(a, t)
    return Solution(z, alpha, solution.t)
