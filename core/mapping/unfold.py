"""Remove fold-overs from a mapping, which FAT sec. 5 leaves as future work.

What folds is untangled by Newton's method in a window around the folds; many folds are cleared on a coarser grid
beforehand (`rehearsal`). Should that not succeed, sizes of features give way: in that window, on a coarser grid and, if
need be, from W itself, which has no folds; then they grow back, behind a barrier that lets nothing fold, as far as
there is room.

There may be no mapping without folds that has the outline at W and the shapes exact. A straight side of a feature that
the picture's edge cuts at both ends has to pass between the outline nodes beside either cut; where W bends the outline
across every such line, or leaves room for a small part of the feature's size only, as it does around a band that
becomes half a ring, `junctions.can_fit` finds that in linear inequalities. The outline then gives way beside the cuts,
as it does should all else fail (`letting_go`).
"""

import numpy as np

from core.arrays import Bools
from core.mapping.approach import (
    REACH,
    STEPS,
    Kind,
    approached,
    blended,
    count_folds,
    folds_widened,
    node_counts,
    placed,
    relaxed,
    steps_to_clear,
    widened,
    window_around,
)
from core.mapping.coarser import Coarser, is_large, unseen
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.first_look import first_look, shown_in_time
from core.mapping.folds import folded_quads
from core.mapping.frames import Complexes
from core.mapping.junctions import can_fit, fit_between, fitted_places, folds_corners
from core.mapping.letting_go import LettingGo
from core.mapping.own_sizes import EXACT, bisected, snapped
from core.mapping.rehearsal import Rehearsal
from core.mapping.stiffen import stiffen
from core.mapping.untangle import Untangler
from core.progress import Job, Progress, part

_CLOSE, _ROOM = 5, 30
"""Cells around what folds that may move at first, and around a feature that grows."""
_STIFF, _SOFT = 20.0, 0.5
"""Stiffness of a feature's scale, per node."""
_MANY, _FEW = 32, 20
"""Features whose windows are kept small, and folds that are worth a search in size before the coarser grid's."""
_MANY_FOLDS, _TOO_MANY = 50, 800
"""Folds from which they are cleared on a coarser grid beforehand, and that it leaves where features do not fit."""
_NARROW_STEPS = 24
"""Newton steps at most in the narrowest windows, where they take little time."""
_GROWTHS = 14
"""Steps at most while features grow."""
_FIRST, _LIGHT, _ROOMY = 1.0, 0.1, 3.0
"""Weight of the barrier when features begin to grow, at last, and where it has to leave room for a finer grid."""


def unfold(mapping: FeatureMapping, w: Complexes) -> Job[Solution]:
    """Return a mapping without folded quads, if W has none; the mapping object is left as it was.

    Where no way is found that has the outline at W, the outline gives way. A step's preview is a first mapping without
    folds, (R, C, 2), on which the rest of the work improves.
    """
    linear = mapping.place(w)
    if folded_quads(w).any() or not count_folds(linear):
        return linear
    return (yield from shown_in_time(_unfolded(mapping, w, linear), lambda: first_look(mapping, w, linear)))


def _unfolded(mapping: FeatureMapping, w: Complexes, linear: Solution) -> Job[Solution]:
    """Return a mapping without folds for W that has none and a linear answer that does."""
    fits, found = can_fit(mapping, w, linear), None
    if fits:
        found = yield from part(_searched(mapping, w, linear), 0.0, 0.7)
    solution = found or (yield from part(LettingGo(mapping, w, linear, fits=fits).finished(), 0.7, 0.9))
    if mapping.keep == "rigid" and len(linear.alpha):
        solution = yield from part(snapped(mapping, w, solution), 0.9, 1.0)
    return solution


def _searched(
    mapping: FeatureMapping, w: Complexes, linear: Solution, *, lightest: float = _LIGHT
) -> Job[Solution | None]:
    """Unfold with the outline at W, features ever freer in size; None if that does not succeed."""
    fitted, rehearsal = fit_between(mapping, w, linear), Rehearsal(mapping, w)
    start = linear if fitted is None else fitted
    solution = yield from part(_nearby(mapping, w, start, rehearsal, fitted=fitted is not None), 0.0, 0.3)
    if count_folds(solution):
        if not len(linear.alpha):
            return blended(w, solution)
        return (yield from part(_resized(mapping, w, solution, linear, lightest=lightest), 0.3, 1.0))
    changed = bool((np.abs(np.log(np.abs(solution.alpha / linear.alpha))) > EXACT).any())
    if mapping.keep == "rigid" and changed:
        solution = yield from part(bisected(mapping, w, solution, rehearsal), 0.3, 0.9)
    if solution is start:
        return solution
    return (yield from part(_relaxed_around(mapping, w, solution, linear if changed else start), 0.9, 1.0))


def _resized(
    mapping: FeatureMapping, w: Complexes, solution: Solution, linear: Solution, *, lightest: float
) -> Job[Solution | None]:
    """Let sizes of features give way: near the folds if they are few, on a coarser grid, at last from W."""
    if not is_large(mapping) or count_folds(solution) < _FEW:
        window = window_around(mapping, solution)
        softened = yield from part(_softened(mapping, w, solution, linear, window), 0.0, 0.2)
        if not count_folds(softened):
            return (yield from part(_grown(mapping, w, softened, linear, lightest=lightest), 0.2, 1.0))
    if is_large(mapping):
        return (yield from part(_from_coarser(mapping, w, linear), 0.2, 1.0))
    found = yield from part(stiffen(mapping, w, np.abs(linear.alpha)), 0.6, 0.9)
    return found and (yield from part(_grown(mapping, w, found, linear, lightest=lightest), 0.9, 1.0))


def _from_coarser(mapping: FeatureMapping, w: Complexes, linear: Solution) -> Job[Solution | None]:
    """Search on a coarser grid, and go on from what is found there; None if that still folds."""
    coarser = Coarser(mapping)
    coarse_w = coarser.at_nodes(w)
    if folded_quads(coarse_w).any() or not coarser.mapping.bodies:
        return None
    coarse = coarser.mapping.place(coarse_w)
    if count_folds(coarse):
        if not can_fit(coarser.mapping, coarse_w, coarse):
            return None
        found = yield from part(unseen(_searched(coarser.mapping, coarse_w, coarse, lightest=_ROOMY)), 0.0, 0.4)
        if found is None:
            return None
        coarse = found
    start = coarser.lifted(w, coarse, linear, released=False)
    if folds_corners(mapping, w, start.alpha, start.t):
        places = fitted_places(mapping, w, start.alpha, start.t)
        start = start if places is None else placed(mapping, start, *places)
    # What is lifted folds in a few places at most, if the coarser grid shows all that matters.
    held, soft = np.full(len(start.alpha), np.inf), _SOFT * node_counts(mapping, start)
    for number, stiffness in enumerate((None, held, soft)):
        window = folds_widened(start, REACH) if stiffness is None else window_around(mapping, start)
        untangler = Untangler(mapping, w, start, window=window, stiffness=stiffness)
        clear = yield from part(steps_to_clear(untangler, "barrier", STEPS), 0.4 + 0.1 * number, 0.5 + 0.1 * number)
        start = untangler.solution
        if clear and not count_folds(start):
            return (yield from part(_grown(mapping, w, start, linear), 0.7, 1.0))
    return None


def _nearby(
    mapping: FeatureMapping, w: Complexes, start: Solution, rehearsal: Rehearsal, *, fitted: bool
) -> Job[Solution]:
    """Unfold close to `start`, features at its sizes; what is returned may still fold.

    Where they have been `fitted` between outline nodes, they stay at first.
    """
    solution, held = start, np.full(len(start.alpha), np.inf)
    if count_folds(solution) >= _MANY_FOLDS:
        solution = yield from part(rehearsal.cleared(solution), 0.0, 0.2)
        if rehearsal.left > _TOO_MANY:
            return solution
    # Around many features, windows would soon cover the whole picture.
    close = _CLOSE if len(start.alpha) > _MANY else REACH
    attempts: list[tuple[Kind, int, int]] = [("barrier", _NARROW_STEPS, close), ("barrier", STEPS, REACH)]
    if not fitted:
        attempts = [("hinge", STEPS, close), *attempts]
    for number, (kind, steps, reach) in enumerate(attempts):
        if not count_folds(solution):
            break
        stays = number == 0 and fitted
        window = folds_widened(solution, reach) if stays else window_around(mapping, solution, reach)
        untangler = Untangler(mapping, w, solution, window=window, stiffness=None if stays else held)
        begin, end = (0.2 + 0.8 * (number + done) / len(attempts) for done in (0, 1))
        yield from part(steps_to_clear(untangler, kind, steps), begin, end)
        if untangler.folds < count_folds(solution):
            solution = untangler.solution
    return solution


def _relaxed_around(mapping: FeatureMapping, w: Complexes, solution: Solution, folded: Solution) -> Job[Solution]:
    """Bring a solution without folds closer to W where `folded` folds, features at their sizes."""
    held = np.full(len(solution.alpha), np.inf)
    window = window_around(mapping, folded)
    return (yield from relaxed(Untangler(mapping, w, solution, window=window, stiffness=held)))


def _softened(
    mapping: FeatureMapping, w: Complexes, solution: Solution, linear: Solution, window: Bools
) -> Job[Solution]:
    """Untangle with sizes that give way; what is returned may still fold."""
    nodes = node_counts(mapping, solution)
    untangler = Untangler(mapping, w, solution, window=window, stiffness=_SOFT * nodes, scales=np.abs(linear.alpha))
    clear = yield from steps_to_clear(untangler, "barrier", STEPS)
    return untangler.solution if clear else solution


def _grown(
    mapping: FeatureMapping, w: Complexes, clear: Solution, linear: Solution, *, lightest: float = _LIGHT
) -> Job[Solution]:
    """Come back to W and to the sizes of the linear answer as far as nothing folds."""
    yield Progress(0.0, "unfolding", clear.positions)
    wanted = np.abs(linear.alpha)
    lost = np.abs(np.log(np.abs(clear.alpha) / wanted))
    if (lost <= EXACT).all():
        return (yield from _relaxed_around(mapping, w, clear, linear))
    window = widened(np.isin(mapping.index, np.flatnonzero(lost > EXACT)), _ROOM)
    stiffness = np.where(lost > EXACT, _STIFF * node_counts(mapping, clear), np.inf)
    untangler = Untangler(mapping, w, clear, window=window, stiffness=stiffness, scales=wanted)
    grown = yield from approached(untangler, clear, _GROWTHS, weight=max(_FIRST, lightest), lightest=lightest)
    still_lost = np.abs(np.log(np.abs(grown.alpha) / wanted))
    return grown if still_lost.sum() <= lost.sum() else clear
