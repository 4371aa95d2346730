"""Give rigid features that unfolding has made larger or smaller their own sizes back, as far as they fit."""

import numpy as np

from core.arrays import Floats
from core.mapping.approach import REACH, STEPS, count_folds, folds_widened, placed, steps_to_clear, window_around
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.frames import Complexes
from core.mapping.junctions import fitted_places, folds_corners, largest_scales
from core.mapping.rehearsal import Rehearsal
from core.mapping.untangle import Untangler
from core.progress import Job, Progress, part

_TRIALS = 3
EXACT = 1e-9
"""Logarithm of a scale that is one."""
_NEARLY = 0.03
"""Logarithm of a scale that is as good as one."""
_TOO_MUCH = 0.1
"""Logarithm of a scale that is not tried to be made up for at once."""
_GAIN = 0.005
"""Logarithm of a scale that is worth a trial."""
_FEW, _MORE = 20, 3
"""Folds that a rehearsal may leave, and times as many as it left of what has been cleared."""
_CLOSE = 6
"""Cells around features, and what folds, that move with them."""
_TOO_DEEP = 0.5
"""Depth of folds that features, where they are held, leave so that moving will not help."""


def bisected(mapping: FeatureMapping, w: Complexes, solution: Solution, rehearsal: Rehearsal) -> Job[Solution]:
    """Bring rigid features that gave way a little back to the largest sizes that fit, all by the same share.

    Those that are all but as large as they were are left to `snapped`.
    """
    lost = np.log(np.abs(solution.alpha))
    if (np.abs(lost) < _NEARLY).all():
        return solution
    yield Progress(0.0, "unfolding", solution.positions)
    best, low, high = solution, 0.0, 1.0
    largest = largest_scales(mapping, w, len(lost))
    most = max(_FEW, _MORE * rehearsal.left)
    # What has lost more than room is worth does not fit as a whole.
    first = int(np.abs(lost).max() > _TOO_MUCH)
    for number in range(first, _TRIALS):
        share = high if number == 0 else (low + high) / 2
        trial = _resized(mapping, solution, np.where(np.abs(lost) < _NEARLY, -lost, -lost * share))
        start, middle, end = ((number + n) / _TRIALS for n in (0, 0.3, 1))
        found = None
        if (np.abs(trial.alpha) <= largest).all():
            trial = _fitted(mapping, w, trial, best)
            trial = yield from part(rehearsal.cleared(trial), start, middle)
            if rehearsal.left <= most:
                found = yield from part(_cleared(mapping, w, trial), middle, end)
        if found is not None:
            low, best = share, found
        if low == high:
            break
        high = high if found is not None else share
    return best


def _fitted(mapping: FeatureMapping, w: Complexes, trial: Solution, best: Solution) -> Solution:
    """Return a trial with features moved to where they fit between outline nodes, if larger than in `best`."""
    if not folds_corners(mapping, w, trial.alpha, trial.t):
        return trial
    places = fitted_places(mapping, w, trial.alpha, trial.t, worth=0.0)
    if places is None or _lost(places[0]) > _lost(best.alpha) - _GAIN:
        return trial
    return placed(mapping, trial, *places)


def _lost(alpha: Complexes) -> float:
    """Return how far sizes are from their own."""
    return float(np.abs(np.log(np.abs(alpha))).sum())


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
    moved = Untangler(mapping, w, start, window=window_around(mapping, start, _CLOSE), stiffness=held)
    clear = yield from part(steps_to_clear(moved, "barrier", STEPS), 0.5, 1.0)
    return moved.solution if clear else None


def _resized(mapping: FeatureMapping, solution: Solution, logarithms: Floats) -> Solution:
    """Scale every feature about its centre."""
    return placed(mapping, solution, solution.alpha * np.exp(logarithms), solution.t)
