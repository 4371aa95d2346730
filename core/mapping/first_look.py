"""A first mapping without folds, in a time that does not depend on how hard the mapping is.

Features stiffen from W on a coarse grid, behind a barrier that lets nothing fold, inside features neither. So each step
of that way folds nothing. Its end is lifted: where it folds, in few places, they are cleared in narrow windows. Should
that fail, a step closer to W is lifted, at last W itself. The outline stays at W, so that features which do not fit
between its nodes are bent there; all others are set exactly where that folds nothing.
"""

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from core.arrays import SingularSystemError
from core.mapping.approach import count_folds, folds_widened, is_clear, steps_to_clear
from core.mapping.coarser import Coarser
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.frames import Complexes, as_positions
from core.mapping.release import outer_nodes
from core.mapping.stiffen import START, Stiffening, tightened
from core.mapping.untangle import Untangler
from core.progress import Job, Progress, Steps, T, part

_PATIENCE = 80_000
"""Unknowns, times steps, of a search that has shown nothing until a first look is taken: some tenths of a second."""
_NODES = 2700
"""Nodes of the coarse grid, about: of the default one every third, either way."""
_STEPS = 24
"""Steps to stiffen at most: each doubles the ties."""
_REACHES, _FEW = (3, 6), 60
"""Cells around folds that may move; folds that are worth clearing."""
_NEWTON, _AGAIN = 16, 8
"""Newton steps to clear them at most, at first and closer to W."""
_BACK = (2, 5, 9, 14, 19)
"""Steps back towards W, where the end of the way cannot be lifted."""
_ROUNDS = 8
"""Times at most that features are set exactly, each time without those that fold something."""


def shown_in_time(job: Job[T], look: Callable[[], Job[Complexes]]) -> Job[T]:
    """Run `job`; when it has worked for long and shown nothing, show what `look` finds, (R, C)."""
    work, is_shown = 0, False
    for step in (steps := Steps(job)):
        yield step
        work, is_shown = work + step.work, is_shown or step.preview is not None
        if not is_shown and work > _PATIENCE:
            found = yield from part(look(), step.fraction, step.fraction)
            yield Progress(step.fraction, "unfolding", as_positions(found))
            is_shown = True
    return steps.result


def first_look(mapping: FeatureMapping, w: Complexes, linear: Solution) -> Job[Complexes]:
    """Return a mapping without folds (R, C) with the outline at W, features nearly in shape and of about their size."""
    cells = max(1.0, float(np.sqrt(mapping.grid.size / _NODES)))
    coarser = Coarser(mapping, covered=True, same_outline=True, cells=cells)
    if not coarser.mapping.bodies:
        return w
    path = yield from part(_stiffened(coarser, coarser.at_nodes(w), _sizes(mapping, linear)), 0.0, 0.7)
    found = yield from part(_lifted(mapping, w, coarser, path[-1], _NEWTON), 0.7, 0.8)
    if not is_clear(mapping, w, found):
        found = yield from part(_closer_to_w(mapping, w, coarser, path), 0.8, 1.0)
    return _with_exact_features(mapping, w, found)


def _sizes(mapping: FeatureMapping, linear: Solution) -> dict[int, float]:
    """Return the scales that features have in the linear answer, by their numbers; none where they have no pose."""
    return {body.number: abs(a) for body, a in zip(mapping.bodies, linear.alpha, strict=False)}


def _stiffened(coarser: Coarser, w: Complexes, sizes: dict[int, float]) -> Job[list[Complexes]]:
    """Return the mappings (R, C) on the way from W to stiff features; none folds what W does not."""
    bodies = coarser.mapping.bodies
    scales = np.array([sizes.get(body.number, abs(body.fit(w.ravel())[0])) for body in bodies])
    stiffening = Stiffening(coarser.mapping, w, scales, whole=True)
    path = [w]
    # A corner that W all but folds, on the coarse grid only, leaves no step to take.
    with suppress(SingularSystemError):
        for step, found in enumerate(tightened(stiffening, START, _STEPS)):
            path.append(stiffening.z.reshape(w.shape))
            if found is not None:
                path.append(found.z)
                break
            yield Progress(step / _STEPS, "stiffening", work=stiffening.size)
    return path


def _lifted(mapping: FeatureMapping, w: Complexes, coarser: Coarser, coarse: Complexes, steps: int) -> Job[Complexes]:
    """Return on the fine grid a mapping of the `coarse` one (R, C), with few folds cleared in narrow windows."""
    z = np.where(outer_nodes(mapping), w, coarser.between(w, coarser.at_nodes(w), coarse))
    for reach in _REACHES:
        now = _loose(z)
        if not 0 < count_folds(now) <= _FEW:
            break
        window, inner = folds_widened(now, reach), ~mapping.grid.outline
        untangler = Untangler(mapping, w, now, window=window, stiffness=None, released=inner)
        yield from steps_to_clear(untangler, "barrier", steps)
        if untangler.folds < count_folds(now):
            z = untangler.solution.z
    return z


def _loose(z: Complexes) -> Solution:
    """Return a mapping in which no feature moves as one, so that all may be bent."""
    none = np.empty(0, np.complex128)
    return Solution(z, none, none)


def _closer_to_w(mapping: FeatureMapping, w: Complexes, coarser: Coarser, path: list[Complexes]) -> Job[Complexes]:
    """Return one late on the `path` from W that can be lifted without folds, W if none of those tried can."""
    for back in _BACK:
        if back < len(path):
            found = yield from _lifted(mapping, w, coarser, path[-1 - back], _AGAIN)
            if is_clear(mapping, w, found):
                return found
    return w


def _with_exact_features(mapping: FeatureMapping, w: Complexes, z: Complexes) -> Complexes:
    """Return a mapping without folds with those of its features set exactly with which it folds nothing."""
    places = [body.fit(z.ravel()) for body in mapping.bodies]
    chosen = set(range(len(places)))
    for _ in range(_ROUNDS):
        found = z.copy()
        for i in chosen:
            found.ravel()[mapping.bodies[i].nodes] = mapping.bodies[i].place(*places[i])
        if is_clear(mapping, w, found):
            return found
        near = mapping.index[folds_widened(_loose(found), 0)]
        chosen -= set(near.tolist())
    return z
