"""Give rigid features that unfolding has made larger or smaller their own sizes back, as far as they fit."""

import numpy as np

from core.arrays import Floats
from core.mapping.approach import REACH, STEPS, count_folds, folds_widened, steps_to_clear, window_around
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.frames import Complexes
from core.mapping.untangle import Untangler
from core.progress import Job, Progress, part

_TRIALS = 3
EXACT = 1e-9
"""Logarithm of a scale that is one."""
_NEARLY = 0.03
"""Logarithm of a scale that is as good as one."""
_TOO_MUCH = 0.1
"""Logarithm of a scale that is not tried to be made up for at once."""
_TOO_DEEP = 0.5
"""Depth of folds that features, where they are held, leave so that moving will not help."""


def bisected(mapping: FeatureMapping, w: Complexes, solution: Solution) -> Job[Solution]:
    """Bring rigid features that gave way a little back to the largest sizes that fit, all by the same share.

    Those that are all but as large as they were are left to `snapped`.
    """
    lost = np.log(np.abs(solution.alpha))
    if (np.abs(lost) < _NEARLY).all():
        return solution
    yield Progress(0.0, "unfolding", solution.positions)
    best, low, high = solution, 0.0, 1.0
    # What has lost more than room is worth does not fit as a whole.
    first = int(np.abs(lost).max() > _TOO_MUCH)
    for number in range(first, _TRIALS):
        share = high if number == 0 else (low + high) / 2
        trial = _resized(mapping, solution, np.where(np.abs(lost) < _NEARLY, -lost, -lost * share))
        start, end = (n / _TRIALS for n in (number, number + 1))
        found = yield from part(_cleared(mapping, w, trial), start, end)
        if found is not None:
            low, best = share, found
        if low == high:
            break
        high = high if found is not None else share
    return best


def snapped(mapping: FeatureMapping, w: Complexes, solution: Solution) -> Job[Solution]:
    """Give rigid features that nearly have their own size that size, if nothing folds."""
    lost = np.log(np.abs(solution.alpha))
    near = (np.abs(lost) < _NEARLY) & (np.abs(lost) > EXACT)
    if not near.any():
        return solution
    found = yield from _cleared(mapping, w, _resized(mapping, solution, np.where(near, -lost, 0.0)))
    return solution if found is None else found


def _cleared(mapping: FeatureMapping, w: Complexes, trial: Solution) -> Job[Solution | None]:
    """Clear what the features at their new sizes fold, first where they are, then as they move; None if that fails."""
    here = Untangler(mapping, w, trial, window=folds_widened(trial, REACH), stiffness=None)
    if here.stuck < -_TOO_DEEP:
        return None
    clear = yield from part(steps_to_clear(here, "barrier", STEPS), 0.0, 0.5)
    if clear and not count_folds(here.solution):
        return here.solution
    if here.worst < -_TOO_DEEP:
        return None
    start, held = here.solution, np.full(len(trial.alpha), np.inf)
    moved = Untangler(mapping, w, start, window=window_around(mapping, start), stiffness=held)
    clear = yield from part(steps_to_clear(moved, "barrier", STEPS), 0.5, 1.0)
    return moved.solution if clear else None


def _resized(mapping: FeatureMapping, solution: Solution, logarithms: Floats) -> Solution:
    """Scale every feature about its centre."""
    z, alpha = solution.z.copy(), solution.alpha * np.exp(logarithms)
    for body, a, t in zip(mapping.bodies, alpha, solution.t, strict=True):
        z.ravel()[body.nodes] = body.place(a, t)
    return Solution(z, alpha, solution.t)
