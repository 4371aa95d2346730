"""Remove fold-overs from a mapping, which FAT sec. 5 leaves as future work.

What folds is untangled by Newton's method in a window around the folds. Should that not succeed, sizes of features give
way: in that window, on a coarser grid and, if need be, from W itself, which has no folds; then they grow back, behind a
barrier that lets nothing fold, as far as there is room.

There may be no mapping without folds that has the outline at W and the shapes exact. A straight side of a feature that
the picture's edge cuts at both ends has to pass between the outline nodes beside either cut; where W bends the outline
across every such line, as it does around a band that becomes half a ring, that is a contradiction of linear
inequalities, which `junctions.can_fit` finds. The outline then gives way, as it does should all else fail: the one
similarity of the whole picture that is closest to W folds nothing and keeps every shape, and from there everything
comes as close to W as it can.
"""

from collections.abc import Callable
from dataclasses import replace

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
    relaxed,
    steps_to_clear,
    widened,
    window_around,
)
from core.mapping.coarser import Coarser, is_large
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.folds import corner_areas, folded_quads
from core.mapping.frames import Complexes, as_complex
from core.mapping.junctions import can_fit, fit_between
from core.mapping.own_sizes import EXACT, bisected, snapped
from core.mapping.stiffen import stiffen
from core.mapping.untangle import Untangler
from core.progress import Job, Progress, part, stepwise

Search = Callable[..., Job[Solution]]

_CLOSE, _ROOM = 5, 30
"""Cells around what folds that may move at first, and around a feature that grows."""
_STIFF, _SOFT = 20.0, 0.5
"""Stiffness of a feature's scale, per node."""
_MANY, _FEW = 32, 20
"""Features whose windows are kept small, and folds that are worth a search in size before the coarser grid's."""
_GROWTHS, _RETURNS, _LAST = 14, 18, 5
"""Steps at most: while features grow; back to W after the outline has been let go; and of these on the fine grid."""
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
    solution = yield from part(_searched(mapping, w, linear), 0.0, 0.9)
    if mapping.keep == "rigid" and len(linear.alpha):
        solution = yield from part(snapped(mapping, w, solution), 0.9, 1.0)
    return solution


def _searched(mapping: FeatureMapping, w: Complexes, linear: Solution, *, lightest: float = _LIGHT) -> Job[Solution]:
    """Unfold with the outline at W, features ever freer in size, else with an outline that gives way."""
    if can_fit(mapping, w, len(linear.alpha)):
        solution = yield from part(_nearby(mapping, w, linear), 0.0, 0.2)
        if not len(linear.alpha):
            return blended(w, solution) if count_folds(solution) else solution
        if not count_folds(solution):
            changed = np.abs(np.log(np.abs(solution.alpha / linear.alpha))).max() > EXACT
            if mapping.keep == "rigid" and changed:
                solution = yield from part(bisected(mapping, w, solution), 0.2, 1.0)
            return solution
        found = yield from part(_resized(mapping, w, solution, linear, lightest=lightest), 0.2, 0.8)
        if found is not None:
            return found
    if is_large(mapping):
        found = yield from part(_from_coarser(mapping, w, linear, _released), 0.8, 0.9)
        if found is not None:
            return found
    return (yield from part(_released(mapping, w, linear, lightest=lightest), 0.9, 1.0))


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
        found = yield from part(_from_coarser(mapping, w, linear, _searched), 0.2, 0.6)
        if found is not None and _keeps_outline(mapping, w, found):
            return found
    found = yield from part(stiffen(mapping, w, np.abs(linear.alpha)), 0.6, 0.9)
    return found and (yield from part(_grown(mapping, w, found, linear, lightest=lightest), 0.9, 1.0))


def _keeps_outline(mapping: FeatureMapping, w: Complexes, solution: Solution) -> bool:
    """Return whether outline nodes outside features are at W."""
    outer = mapping.grid.outline & (mapping.index < 0)
    return bool((solution.z == w)[outer].all())


def _from_coarser(mapping: FeatureMapping, w: Complexes, linear: Solution, search: Search) -> Job[Solution | None]:
    """Search on a coarser grid, and go on from what is found there; None if that still folds."""
    coarser = Coarser(mapping)
    coarse_w = coarser.at_nodes(w)
    if folded_quads(coarse_w).any() or not coarser.mapping.bodies:
        return None
    found = coarser.mapping.place(coarse_w)
    if count_folds(found):
        found = yield from part(_unseen(search(coarser.mapping, coarse_w, found, lightest=_ROOMY)), 0.0, 0.4)
    released = not _keeps_outline(coarser.mapping, coarse_w, found)
    start = coarser.lifted(w, found, linear, released=released)
    soft, everywhere = _SOFT * node_counts(mapping, start), np.ones(w.shape, bool)
    if released and mapping.keep == "rigid":
        soft = np.full(len(soft), np.inf)
    if not released:
        # What is lifted folds in a few places at most, if the coarser grid shows all that matters.
        here = Untangler(mapping, w, start, window=folds_widened(start, REACH), stiffness=None)
        clear = yield from part(steps_to_clear(here, "barrier", STEPS), 0.4, 0.6)
        if clear and not count_folds(here.solution):
            return (yield from part(_grown(mapping, w, here.solution, linear), 0.6, 1.0))
        start = here.solution
    for window in (window_around(mapping, start), everywhere)[: 1 + released]:
        untangler = Untangler(mapping, w, start, window=window, stiffness=soft, released=released)
        clear = yield from part(steps_to_clear(untangler, "barrier", STEPS), 0.4, 0.8)
        start = untangler.solution
        if clear and released:
            last = Untangler(mapping, w, start, window=everywhere, stiffness=40 * soft, released=True)
            return (yield from part(approached(last, start, _LAST, weight=_ROOMY), 0.8, 1.0))
        if clear:
            return (yield from part(_grown(mapping, w, start, linear), 0.8, 1.0))
    return None


def _unseen(job: Job[Solution]) -> Job[Solution]:
    """Run `job` without its previews, which are of another grid."""
    return stepwise(job, lambda step: replace(step, preview=None))


def _nearby(mapping: FeatureMapping, w: Complexes, linear: Solution) -> Job[Solution]:
    """Unfold close to the linear answer, features at its sizes; what is returned may still fold."""
    fitted = fit_between(mapping, w, linear)
    solution = linear if fitted is None else fitted
    # Around many features, windows would soon cover the whole picture.
    close = _CLOSE if len(linear.alpha) > _MANY else REACH
    attempts: list[tuple[Kind, int, int]] = [("barrier", STEPS // 2, close), ("barrier", STEPS, REACH)]
    if fitted is None:
        attempts = [("hinge", STEPS, close), *attempts]
    held, wide = np.full(len(solution.alpha), np.inf), window_around(mapping, solution)
    for number, (kind, steps, reach) in enumerate(attempts):
        if not count_folds(solution):
            break
        # What has been fitted between outline nodes is to stay there at first.
        stays = number == 0 and fitted is not None
        window = folds_widened(solution, reach) if stays else window_around(mapping, solution, reach)
        untangler = Untangler(mapping, w, solution, window=window, stiffness=None if stays else held)
        start, end = (n / len(attempts) for n in (number, number + 1))
        clear = yield from part(steps_to_clear(untangler, kind, steps), start, end)
        if clear:
            again = Untangler(mapping, w, untangler.solution, window=wide, stiffness=held)
            return (yield from part(relaxed(again), end, 1.0))
        if untangler.folds < count_folds(solution):
            solution = untangler.solution
    return solution


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
    window = widened(np.isin(mapping.index, np.flatnonzero(lost > EXACT)), _ROOM)
    stiffness = np.where(lost > EXACT, _STIFF * node_counts(mapping, clear), np.inf)
    untangler = Untangler(mapping, w, clear, window=window, stiffness=stiffness, scales=wanted)
    grown = yield from approached(untangler, clear, _GROWTHS, weight=max(_FIRST, lightest), lightest=lightest)
    still_lost = np.abs(np.log(np.abs(grown.alpha) / wanted))
    return grown if still_lost.sum() <= lost.sum() else clear


def _released(mapping: FeatureMapping, w: Complexes, linear: Solution, *, lightest: float = _LIGHT) -> Job[Solution]:
    """Take the similarity of the whole picture that is closest to W, and come as close to W as nothing folds."""
    rest = as_complex(mapping.grid.nodes)
    arms = rest - rest.mean()
    towards = complex(np.vdot(arms, w))
    size = 1.0 if mapping.keep == "rigid" else np.sqrt(np.abs(corner_areas(w)).mean() / corner_areas(rest).mean())
    alpha = complex(size * (towards / abs(towards) if towards else 1))
    z = alpha * arms + w.mean()
    count = len(linear.alpha)
    centres = np.array([z.ravel()[body.nodes].mean() for body in mapping.bodies[:count]])
    start = Solution(z, np.full(count, alpha), centres)
    held = np.full(count, np.inf) if mapping.keep == "rigid" else _STIFF * node_counts(mapping, start)
    everywhere = np.ones(mapping.grid.shape, bool)
    untangler = Untangler(
        mapping, w, start, window=everywhere, stiffness=held, scales=np.abs(linear.alpha), released=True
    )
    return (yield from approached(untangler, start, _RETURNS, lightest=lightest))
