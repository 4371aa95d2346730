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
from core.mapping.approach import count_folds, folds_widened, node_counts, widened
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
_PATIENCE, _NEARER = 12, 0.97
"""It has ended where so many steps have not brought the farthest node this much nearer."""
_ROUNDS, _FLAT = 2, 0.005
"""Times that this is done at most; share of its area under W below which a corner has been pressed flat."""
_NEAR = (2.0, 0.5, 0.1, 0.02)
"""Cells from W within which nodes are set there, if that folds nothing."""
_TRIALS = 4
"""Times that this is tried, each time without those near what folds."""
_STIFF, _SOFT = 20.0, 0.5
"""Stiffness of a feature's scale, per node: in the end, and on the way."""


def reeled(mapping: FeatureMapping, w: Complexes, scales: Floats, *, lightest: float, fits: bool) -> Job[Solution]:
    """Return a mapping without folds that has the outline at W where it can, and features close to `scales`.

    The barrier's weight falls to `lightest`. `fits` says whether each feature on its own fits between outline nodes.
    """
    best, fewest = None, 0
    jobs = ways(mapping, w, scales, fits=fits)
    for number, way in enumerate(jobs):
        begin, middle, end = ((number + done) / len(jobs) for done in (0.0, 0.8, 1.0))
        start, loose = yield from part(way, begin, middle)
        if start is None:
            continue
        found = yield from part(settled(mapping, w, start, loose, scales, lightest=lightest), middle, end)
        astray = count_astray(mapping, loose)
        if best is None or astray < fewest:
            best, fewest = found, astray
        if not fewest:
            break
    assert best is not None
    return best


def ways(
    mapping: FeatureMapping, w: Complexes, scales: Floats, *, fits: bool
) -> list[Job[tuple[Solution | None, Bools]]]:
    """Return jobs that each let the outline go in another way, the quickest and best first.

    They return a mapping without folds, the last ones always, and the outline nodes (R, C) that stay loose.
    """
    far, further = _far(mapping, _BESIDE), _far(mapping, _WIDER)
    released = [np.zeros_like(far)] * fits + [outer_nodes(mapping) & ~far]
    pulls = (far, _BLUNT), (further, _SHARP), (further, _BLUNT)
    stiffened = [_stiffened(mapping, w, scales, loose) for loose in released]
    return stiffened + [_drawn(mapping, w, scales, nodes, barrier) for nodes, barrier in pulls]


def count_astray(mapping: FeatureMapping, loose: Bools) -> int:
    """Return how many of the nodes (R, C) that stay loose are not beside a cut."""
    return int((loose & _far(mapping, _WIDER)).sum())


def _stiffened(
    mapping: FeatureMapping, w: Complexes, scales: Floats, loose: Bools
) -> Job[tuple[Solution | None, Bools]]:
    """Stiffen features from W with outline nodes (R, C) that are `loose`."""
    return (yield from stiffen(mapping, w, scales, released=loose)), loose


def settled(
    mapping: FeatureMapping, w: Complexes, start: Solution, loose: Bools, scales: Floats, *, lightest: float
) -> Job[Solution]:
    """Bring a solution without folds closer to W and to `scales`, with outline nodes (R, C) that stay `loose`.

    So do those beside what the outline presses flat, since nothing else can widen that.
    """
    found = start
    for number in range(_ROUNDS):
        everywhere, stiffness = np.ones(w.shape, bool), _STIFF * node_counts(mapping, start)
        untangler = Untangler(
            mapping, w, found, window=everywhere, stiffness=stiffness, scales=scales, released=loose, clear=True
        )
        untangler.tie(loose & _far(mapping, _WIDER), _AT_LAST)
        for step in range(_GROWTHS):
            # Corners that have been pressed flat are widened first.
            untangler.step(Barrier(_EPSILON), max(_WIDEN * _LIGHTER**step, lightest))
            yield Progress((number + step / _GROWTHS) / _ROUNDS, "unfolding", work=untangler.size)
        found = untangler.solution
        pressed = outer_nodes(mapping) & _beside_flat(w, found)
        if not (pressed & ~loose).any():
            break
        loose = loose | pressed
    return found


def _beside_flat(w: Complexes, solution: Solution) -> Bools:
    """Return the nodes (R, C) of quads that have lost almost all of a corner's area under W, and those next to them."""
    flat = ((corner_areas(solution.z) / corner_areas(w)).min(axis=0) < _FLAT).astype(np.uint8)
    nodes = np.pad(flat, ((0, 1), (0, 1)))
    for shift in ((0, 1), (1, 0), (1, 1)):
        nodes |= np.pad(flat, ((shift[0], 1 - shift[0]), (shift[1], 1 - shift[1])))
    return widened(nodes > 0, 1)


def _far(mapping: FeatureMapping, beside: int) -> Bools:
    """Return the outline nodes (R, C) that are not within `beside` cells of a feature which the edge cuts."""
    outer = outer_nodes(mapping)
    return np.asarray(outer & ~widened(mapping.grid.outline & ~outer, beside))


def _drawn(
    mapping: FeatureMapping, w: Complexes, scales: Floats, far: Bools, barrier: tuple[float, float]
) -> Job[tuple[Solution | None, Bools]]:
    """Draw outline nodes (R, C) that are `far` from cuts to W behind a `barrier` with ε and a fall of its weight.

    Returns what that leads to, and the outline nodes (R, C) that stay loose.
    """
    outer, (epsilon, fall) = outer_nodes(mapping), barrier
    now = _as_one(mapping, w, len(scales))
    everywhere, stiffness = np.ones(w.shape, bool), _SOFT * node_counts(mapping, now)
    untangler = Untangler(
        mapping, w, now, window=everywhere, stiffness=stiffness, scales=scales, released=outer, clear=True
    )
    tie, distances = _TIE, list[float]()
    for step in range(_PULLS):
        untangler.tie(far, tie)
        moved = untangler.step(Barrier(epsilon), fall**step)
        now = untangler.solution
        distances.append(float(np.abs(now.z - w)[far].max(initial=0.0)))
        if distances[-1] < _NEAR[0] * untangler.side:
            found = _set_at(mapping, w, now, far)
            if found is not None:
                return found, outer & ~far
        if step >= _PATIENCE and min(distances[-_PATIENCE:]) > _NEARER * min(distances[:-_PATIENCE]):
            break
        tie *= _TIGHTEN if moved else 1 / _TIGHTEN
        yield Progress(step / _PULLS, "unfolding", work=untangler.size)
    for cells in _NEAR:
        near = far & (np.abs(now.z - w) < cells * untangler.side)
        for _ in range(_TRIALS):
            found = _set_at(mapping, w, now, near)
            if found is not None:
                return found, outer & ~near
            near &= ~folds_widened(replace(now, z=np.where(near, w, now.z)), 1)
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
