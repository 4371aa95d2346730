"""Let the outline go where no mapping without folds has it at W, and no more of it than has to.

Features stiffen from W with the outline nodes loose that are beside features which the edge cuts. Where W turns a
feature so far that this leads nowhere, the way begins at the other end: from the one similarity of the whole picture
that is closest to W, which folds nothing and keeps every shape, outline nodes are drawn to W by ties that grow, behind
a barrier that lets nothing fold; sizes of features give way on the way. Then those too stay loose that did not come
near W.
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
from core.mapping.stiffen import stiffen
from core.mapping.untangle import Untangler
from core.progress import Job, Progress, part

_BESIDE, _WIDER = 1, 2
"""Cells beside a cut whose outline nodes stay loose, at first and should that not do."""
_PULLS, _GROWTHS = 56, 14
"""Steps at most: while the outline is drawn to W, and after that."""
_TIE, _TIGHTEN, _AT_LAST = 1e-3, 2.0, 1.0
"""The first tie, its growth, and that of nodes which cannot be at W in the end."""
_BLUNT, _SHARP = (0.01, 0.92), (0.003, 0.94)
"""ε of the barrier on the way, and the fall of its weight a step: where one fails, the other may not."""
_WIDEN, _LIGHTER, _EPSILON = 100.0, 0.5, 0.01
"""Weight of the barrier after that, its fall a step, and its ε."""
_NEAR = (2.0, 0.5, 0.1, 0.02)
"""Cells from W within which nodes are set there, if that folds nothing."""
_STIFF, _SOFT = 20.0, 0.5
"""Stiffness of a feature's scale, per node: in the end, and on the way."""


def reeled(mapping: FeatureMapping, w: Complexes, scales: Floats, *, lightest: float, fits: bool) -> Job[Solution]:
    """Return a mapping without folds that has the outline at W where it can, and features close to `scales`.

    The barrier's weight falls to `lightest`. `fits` says whether each feature on its own fits between outline nodes.
    """
    far, further = _far(mapping, _BESIDE), _far(mapping, _WIDER)
    none, beside = np.zeros_like(far), outer_nodes(mapping) & ~far
    for number, loose in enumerate([none, beside] if fits else [beside]):
        begin, middle, end = (0.1 * number + share for share in (0.0, 0.05, 0.1))
        stiff = yield from part(stiffen(mapping, w, scales, released=loose), begin, middle)
        if stiff is not None:
            found = yield from part(_settled(mapping, w, stiff, loose, scales, lightest=lightest), middle, end)
            if not (loose.any() and crosses_itself(found.z.ravel()[around(mapping.grid)])):
                return found
    drawn, loose = yield from part(_drawn(mapping, w, scales, far, _BLUNT), 0.2, 0.5)
    if (loose & far).any():
        again, fewer = yield from part(_drawn(mapping, w, scales, further, _SHARP), 0.5, 0.8)
        if (fewer & further).sum() < (loose & further).sum():
            drawn, loose = again, fewer
    return (yield from part(_settled(mapping, w, drawn, loose, scales, lightest=lightest), 0.8, 1.0))


def _settled(
    mapping: FeatureMapping, w: Complexes, start: Solution, loose: Bools, scales: Floats, *, lightest: float
) -> Job[Solution]:
    """Bring a solution without folds closer to W and to `scales`, with outline nodes (R, C) that stay `loose`."""
    everywhere, stiffness = np.ones(w.shape, bool), _STIFF * node_counts(mapping, start)
    untangler = Untangler(
        mapping, w, start, window=everywhere, stiffness=stiffness, scales=scales, released=loose, clear=True
    )
    untangler.tie(loose & _far(mapping, _WIDER), _AT_LAST)
    for step in range(_GROWTHS):
        # Corners that have been pressed flat are widened first.
        untangler.step(Barrier(_EPSILON), max(_WIDEN * _LIGHTER**step, lightest))
        yield Progress(step / _GROWTHS, "unfolding")
    return untangler.solution


def _far(mapping: FeatureMapping, beside: int) -> Bools:
    """Return the outline nodes (R, C) that are not within `beside` cells of a feature which the edge cuts."""
    outer = outer_nodes(mapping)
    return np.asarray(outer & ~widened(mapping.grid.outline & ~outer, beside))


def _drawn(
    mapping: FeatureMapping, w: Complexes, scales: Floats, far: Bools, barrier: tuple[float, float]
) -> Job[tuple[Solution, Bools]]:
    """Draw outline nodes (R, C) that are `far` from cuts to W behind a `barrier` with ε and a fall of its weight.

    Returns what that leads to, and the outline nodes (R, C) that stay loose.
    """
    outer, (epsilon, fall) = outer_nodes(mapping), barrier
    now = _as_one(mapping, w, len(scales))
    everywhere, stiffness = np.ones(w.shape, bool), _SOFT * node_counts(mapping, now)
    untangler = Untangler(
        mapping, w, now, window=everywhere, stiffness=stiffness, scales=scales, released=outer, clear=True
    )
    tie = _TIE
    for step in range(_PULLS):
        untangler.tie(far, tie)
        moved = untangler.step(Barrier(epsilon), fall**step)
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
