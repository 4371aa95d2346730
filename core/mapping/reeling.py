"""Let the outline go where no mapping without folds has it at W, and draw it back but for what cannot be there.

From the one similarity of the whole picture that is closest to W, which folds nothing and keeps every shape, outline
nodes are drawn to W by ties that grow, behind a barrier that lets nothing fold; sizes of features give way on the way.
Loose in the end are those beside features that the edge cuts, and those that did not come near W.
"""

from dataclasses import replace

import numpy as np

from core.arrays import Bools, Floats
from core.mapping.approach import count_folds, node_counts, widened
from core.mapping.distortion import Barrier
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.folds import corner_areas
from core.mapping.frames import Complexes, as_complex
from core.mapping.release import around, crosses_itself, outer_nodes
from core.mapping.untangle import Untangler
from core.progress import Job, Progress, part

_BESIDE = 3
"""Cells beside a cut whose outline nodes stay loose."""
_PULLS, _GROWTHS = 28, 14
"""Steps at most: while the outline is drawn to W, and after that."""
_TIE, _TIGHTEN, _AT_LAST = 1e-3, 4.0, 1.0
"""The first tie, its growth, and that of nodes which cannot be at W in the end."""
_WEIGHTS: Floats = np.array([0.85**step for step in range(_PULLS)])
_BLUNT: Floats = np.full(_PULLS, 0.01)
_SHARP: Floats = 0.01 * _WEIGHTS
"""The barrier's weights on the way and its ε, which is a matter of luck: where one fails, the other may not."""
_WIDEN, _LIGHTER = 100.0, 0.5
"""Weight of the barrier after that, and its fall a step."""
_NEAR = (2.0, 0.5, 0.1, 0.02)
"""Cells from W within which nodes are set there, if that folds nothing."""
_STIFF, _SOFT = 20.0, 0.5
"""Stiffness of a feature's scale, per node: in the end, and on the way."""


def reeled(mapping: FeatureMapping, w: Complexes, scales: Floats, *, lightest: float) -> Job[Solution]:
    """Return a mapping without folds that has the outline at W where it can, and features close to `scales`.

    The barrier's weight falls to `lightest`.
    """
    drawn, loose = yield from part(_drawn(mapping, w, scales, _BLUNT), 0.0, 0.3)
    if (loose & _far(mapping)).any():
        again, fewer = yield from part(_drawn(mapping, w, scales, _SHARP), 0.3, 0.6)
        if fewer.sum() < loose.sum():
            drawn, loose = again, fewer
    everywhere, stiffness = np.ones(w.shape, bool), _STIFF * node_counts(mapping, drawn)
    untangler = Untangler(
        mapping, w, drawn, window=everywhere, stiffness=stiffness, scales=scales, released=loose, clear=True
    )
    untangler.tie(loose & _far(mapping), _AT_LAST)
    for step in range(_GROWTHS):
        # Corners that have been pressed flat are widened first.
        untangler.step(Barrier(_BLUNT[0]), max(_WIDEN * _LIGHTER**step, lightest))
        yield Progress(0.6 + 0.4 * step / _GROWTHS, "unfolding")
    return untangler.solution


def _far(mapping: FeatureMapping) -> Bools:
    """Return the outline nodes (R, C) that are not beside a feature which the edge cuts."""
    outer = outer_nodes(mapping)
    return np.asarray(outer & ~widened(mapping.grid.outline & ~outer, _BESIDE))


def _drawn(mapping: FeatureMapping, w: Complexes, scales: Floats, epsilons: Floats) -> Job[tuple[Solution, Bools]]:
    """Draw the outline to W behind barriers with ε = `epsilons`, one a step.

    Returns what that leads to, and the outline nodes (R, C) that stay loose.
    """
    outer, far = outer_nodes(mapping), _far(mapping)
    now = _as_one(mapping, w, len(scales))
    everywhere, stiffness = np.ones(w.shape, bool), _SOFT * node_counts(mapping, now)
    untangler = Untangler(
        mapping, w, now, window=everywhere, stiffness=stiffness, scales=scales, released=outer, clear=True
    )
    tie = _TIE
    for step, (weight, epsilon) in enumerate(zip(_WEIGHTS, epsilons, strict=True)):
        untangler.tie(far, tie)
        moved = untangler.step(Barrier(float(epsilon)), weight)
        now = untangler.solution
        if np.abs(now.z - w)[far].max(initial=0.0) < _NEAR[0] * untangler.side:
            found = _set_at(mapping, w, now, far)
            if found is not None:
                return found, outer & ~far
        tie *= _TIGHTEN if moved else 1 / _TIGHTEN
        yield Progress(step / _PULLS, "unfolding")
    for cells in _NEAR:
        near = far & (np.abs(now.z - w) < cells * untangler.side)
        found = _set_at(mapping, w, now, near)
        if found is not None:
            return found, outer & ~near
    return now, outer


def _set_at(mapping: FeatureMapping, w: Complexes, solution: Solution, nodes: Bools) -> Solution | None:
    """Return `solution` with `nodes` at W, None if that folds something or the outline crosses itself."""
    found = replace(solution, z=np.where(nodes, w, solution.z))
    if count_folds(found) or crosses_itself(found.z.ravel()[around(mapping.grid)]):
        return None
    return found


def _as_one(mapping: FeatureMapping, w: Complexes, count: int) -> Solution:
    """Return the similarity of the whole picture that is closest to W, for `count` features."""
    rest = as_complex(mapping.grid.nodes)
    arms = rest - rest.mean()
    towards = complex(np.vdot(arms, w))
    size = float(np.sqrt(np.abs(corner_areas(w)).mean() / corner_areas(rest).mean()))
    alpha = size * (towards / abs(towards) if towards else 1)
    z = alpha * arms + w.mean()
    centres = np.array([z.ravel()[body.nodes].mean() for body in mapping.bodies[:count]], np.complex128)
    return Solution(z, np.full(count, alpha, np.complex128), centres)
