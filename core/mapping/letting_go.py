"""Unfold with an outline that gives way: on a coarse grid, where it takes little time, then on ever finer ones.

On each grid features cover all nodes that they have on the next finer one, so that little or nothing folds when what is
found is lifted.
"""

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from core.arrays import Bools, Floats
from core.mapping.approach import (
    REACH,
    STEPS,
    approached,
    count_folds,
    folds_widened,
    is_clear,
    node_counts,
    steps_to_clear,
    widened,
)
from core.mapping.coarser import Coarser, unseen
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.folds import folded_quads
from core.mapping.frames import Complexes
from core.mapping.reeling import count_astray, reeled, settled, ways
from core.mapping.release import outer_nodes
from core.mapping.stiffen import stiffen
from core.mapping.untangle import Untangler
from core.progress import Job, Progress, part

_ENOUGH, _MANY = 1500, 6000
"""Nodes of a grid that is coarse enough, and from which the next one has cells three times as large, not twice."""
_UNCOVERED = 0.75
"""Share of the outline outside features that stays so on a coarser grid which is like the finest."""
_CLOSE = 5
"""Cells around what folds that may move at first."""
_FEW = 60
"""Folds that are worth clearing."""
_FAILURES = 2
"""Ways from a grid to the finest that end in folds, after which one begins on the next finer grid; where features fit,
from W on the finest."""
_STIFF = 20.0
"""Stiffness of a feature's scale, per node."""
_BEND = 2
"""Outline nodes that in the end go with those that left W, since the outline bends there."""
_GROWTHS, _LAST = 8, 2
"""Steps at most on the way down, and on the finest grid."""
_WIDE, _ROOMY, _LIGHT = 30.0, 3.0, 0.1
"""Weight of the barrier on the way down, at first and in the end, where it leaves room; the least without a way."""


class LettingGo:
    """The way from a coarse grid, on which the outline is let go of, down to the mapping's own.

    `fits` says whether each feature on its own fits between the outline nodes.
    """

    def __init__(self, mapping: FeatureMapping, w: Complexes, linear: Solution, *, fits: bool) -> None:
        self._mapping, self._w, self._linear, self._fits = mapping, w, linear, fits
        self._sizes = {body.number: abs(a) for body, a in zip(mapping.bodies, linear.alpha, strict=False)}
        self._drawn: list[Solution] = []
        """What was found on a coarse grid and lifted, from there down to the finest."""

    @cached_property
    def _coarser(self) -> list[tuple[Coarser, Complexes]]:
        """Ever coarser grids, with W at their nodes."""
        return list(_ever_coarser(self._mapping, self._w))

    def _searched(self) -> Job[None]:
        """Look for mappings without folds, on ever finer grids, and show them."""
        count = len(self._coarser)
        for first in range(count, 0, -1):
            is_like = _outer_share(self._coarser[first - 1][0].mapping) >= _UNCOVERED * _outer_share(self._mapping)
            job = self._drawn_from(first, at_once=not is_like)
            yield from part(job, 1 - first / count, 1 - (first - 1) / count)
            if self._drawn and is_like:
                return

    def _drawn_from(self, first: int, *, at_once: bool) -> Job[None]:
        """Try ways on the grid of a level, until the outline is loose only where it has to be.

        What has to be found `at_once` is but shown until a finer grid, where features cover less of the outline, does.
        """
        coarser, w = self._coarser[first - 1]
        mapping, scales, fewest = coarser.mapping, self._scales(coarser.mapping), np.inf
        jobs = ways(mapping, w, scales, fits=self._fits)
        jobs, failures = jobs[: 1 + self._fits] if at_once else jobs, 0
        for number, way in enumerate(jobs):
            begin, middle, nearly, end = ((number + done) / len(jobs) for done in (0.0, 0.6, 0.8, 1.0))
            start, loose = yield from unseen(part(way, begin, middle))
            astray = count_astray(mapping, loose)
            if start is None or astray >= fewest:
                continue
            job = settled(mapping, w, start, loose, scales, lightest=_ROOMY)
            found = yield from unseen(part(job, middle, nearly))
            drawn = yield from part(self._brought_down(first, found), nearly, end)
            if is_clear(self._mapping, self._w, drawn[-1].z):
                self._drawn, fewest = drawn, astray
                yield Progress(end, "unfolding", drawn[-1].positions)
            else:
                failures += 1
            if not fewest or (failures == _FAILURES and (first > 1 or self._fits)):
                return

    def _brought_down(self, first: int, found: Solution) -> Job[list[Solution]]:
        """Return what was `found` on the grid of a level and what becomes of it on every finer one, at last the finest.

        To begin on another grid costs less than a long search after a way from one that is very coarse.
        """
        drawn, attempts = [found], 3 if first == 1 else 1
        for level in range(first, 0, -1):
            begin, end = ((first - level + done) / (first + 1) for done in (0, 1))
            mapping, w, _ = self._at(level - 1)
            lifted = self._lifted(level, drawn[-1])
            drawn.append((yield from part(_cleared(mapping, w, lifted, attempts=attempts), begin, end)))
        if first == 1 and count_folds(drawn[-1]):
            drawn[-1] = yield from part(self._stiffened(drawn), 0.5, 1.0)
        return drawn

    def _stiffened(self, drawn: list[Solution]) -> Job[Solution]:
        """Return the last of what was `drawn`, or what features stiffen to from where the grid before has all nodes."""
        coarser, coarse_w = self._coarser[0]
        lifted, nearly = drawn[-1], coarser.between(self._w, coarse_w, drawn[-2].z)
        scales, loose = self._scales(self._mapping), _loose(self._mapping, self._w, lifted, bend=0)
        released = np.zeros_like(loose) if self._fits else loose
        start = np.where(outer_nodes(self._mapping) & ~released, self._w, nearly)
        if folded_quads(start).any():
            return lifted
        found = yield from stiffen(self._mapping, self._w, scales, released=released, start=start)
        return lifted if found is None else found

    def finished(self) -> Job[Solution]:
        """Return a mapping without folds that has the outline at W where it can, and features close to their sizes."""
        yield from part(self._searched(), 0.0, 0.4)
        if not self._drawn:
            sizes = np.abs(self._linear.alpha)
            return (yield from part(reeled(self._mapping, self._w, sizes, lightest=_LIGHT, fits=self._fits), 0.4, 1.0))
        found, clear = self._drawn[0], self._drawn[-1]
        levels = len(self._drawn) - 1
        for level in range(levels, 0, -1):
            begin, middle, end = (0.7 - 0.3 * (level - done) / levels for done in (0.0, 0.5, 1.0))
            mapping, w, _ = self._at(level - 1)
            lifted = self._lifted(level, found)
            lifted = yield from unseen(part(_cleared(mapping, w, lifted, attempts=1), begin, middle))
            if not is_clear(mapping, w, lifted.z):
                break
            if level == 1:
                clear = lifted
            else:
                found = yield from unseen(part(_refined(mapping, w, lifted, self._scales(mapping)), middle, end))
        return (yield from part(_polished(self._mapping, self._w, clear), 0.7, 1.0))

    def _at(self, level: int) -> tuple[FeatureMapping, Complexes, Solution]:
        """Return the mapping, W and the linear answer on a grid; 0 is the finest."""
        if not level:
            return self._mapping, self._w, self._linear
        coarser, w = self._coarser[level - 1]
        return coarser.mapping, w, coarser.mapping.place(w)

    def _lifted(self, level: int, found: Solution) -> Solution:
        """Return on the next finer grid what was `found` on that of a level."""
        _, w, linear = self._at(level - 1)
        return self._coarser[level - 1][0].lifted(w, found, linear, released=True)

    def _scales(self, mapping: FeatureMapping) -> Floats:
        """Return the scales of features in the linear answer, on whatever grid."""
        return np.array([self._sizes[body.number] for body in mapping.bodies])


def _ever_coarser(mapping: FeatureMapping, w: Complexes) -> Iterator[tuple[Coarser, Complexes]]:
    """Yield ever coarser grids with W at their nodes, as long as it folds nowhere and there are features."""
    while mapping.grid.size > _ENOUGH and mapping.has_poses:
        coarser = Coarser(mapping, covered=True, cells=3 if mapping.grid.size > _MANY else 2)
        mapping, w = coarser.mapping, coarser.at_nodes(w)
        if folded_quads(w).any() or not mapping.bodies:
            return
        yield coarser, w


def _outer_share(mapping: FeatureMapping) -> float:
    """Return the share of the outline outside features."""
    return float(outer_nodes(mapping).sum() / mapping.grid.outline.sum())


def _loose(mapping: FeatureMapping, w: Complexes, solution: Solution, *, bend: int) -> Bools:
    """Return the outline nodes (R, C) that left W, with `bend` more to either side."""
    outer = outer_nodes(mapping)
    return np.asarray(outer & widened(outer & (solution.z != w), bend))


def _cleared(mapping: FeatureMapping, w: Complexes, start: Solution, *, attempts: int) -> Job[Solution]:
    """Clear the few folds of a lifted solution, in windows that become wider."""
    solution, soft = start, _STIFF * node_counts(mapping, start)
    loose = _loose(mapping, w, start, bend=_BEND)
    for reach, stiffness in ((_CLOSE, None), (REACH, None), (REACH, soft))[:attempts]:
        folds = count_folds(solution)
        if not 0 < folds <= _FEW:
            break
        window = folds_widened(solution, reach)
        untangler = Untangler(mapping, w, solution, window=window, stiffness=stiffness, released=loose)
        if untangler.stuck <= 0:
            continue
        yield from steps_to_clear(untangler, "barrier", STEPS)
        if count_folds(untangler.solution) < folds:
            solution = untangler.solution
    return solution


def _refined(mapping: FeatureMapping, w: Complexes, start: Solution, scales: Floats) -> Job[Solution]:
    """Bring a lifted solution closer to W and to `scales`."""
    everywhere, stiffness = np.ones(w.shape, bool), _STIFF * node_counts(mapping, start)
    loose = _loose(mapping, w, start, bend=0)
    untangler = Untangler(
        mapping, w, start, window=everywhere, stiffness=stiffness, scales=scales, released=loose, clear=True
    )
    return (yield from approached(untangler, start, _GROWTHS, weight=_WIDE, lightest=_ROOMY))


def _polished(mapping: FeatureMapping, w: Complexes, start: Solution) -> Job[Solution]:
    """Smooth on the finest grid what was lifted to it."""
    everywhere, held = np.ones(w.shape, bool), np.full(len(start.alpha), np.inf)
    loose = _loose(mapping, w, start, bend=_BEND)
    untangler = Untangler(mapping, w, start, window=everywhere, stiffness=held, released=loose)
    return (yield from approached(untangler, start, _LAST, weight=_ROOMY, lightest=_ROOMY))
