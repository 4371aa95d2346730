"""Maps without folds to begin at, or to come back to, where the linear answer leads to none."""

from dataclasses import replace

import numpy as np

from core.arrays import Ints
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.handles.constraints import ALONG_X, SCALE, TURN
from core.mapping.injective.levels import GridLevel, Map
from core.mapping.injective.problem import Goal
from core.mapping.injective.windows import count_folds
from core.mapping.jacobians import Complexes, linear_parts

_SEED = 0.2
"""Share of its size that a body begins with where nothing else is known not to fold."""
_HALVINGS = 8
"""Times that the way from a map without folds to one that folds is halved."""


def similar(level: GridLevel) -> Map:
    """Return the one similarity of the whole that is closest to S: it folds nothing and keeps every body."""
    rest, shape, pivots = level.rest, level.shape.ravel(), level.constraints.pivots
    arms = rest - rest.mean()
    alpha = np.vdot(arms, shape) / np.vdot(arms, arms)
    place = shape.mean() + alpha * (pivots - rest.mean())
    return Map(shape.mean() + alpha * arms, np.full(len(place), alpha), place)


def posed(mapping: FeatureMapping, level: GridLevel, goal: Goal, near: Map, centres: Complexes) -> Map:
    """Return the linear answer for bodies placed as in another map, at their own sizes, about `centres` (n,)."""
    found = level.solution_of(replace(near, alpha=goal.scales * np.exp(1j * np.angle(near.alpha))), centres)
    return level.of_solution(mapping.place_at(level.wanted, found.alpha, found.t), centres)


def small(level: GridLevel, goal: Goal) -> Map:
    """Return S with bodies in it that are turned as S is, and so small that nothing folds, if halving finds that.

    What the outline cuts is small there. Around bodies of no size nothing folds where one point sees all of the rim.
    """
    held, inside, S = level.constraints, level.index >= 0, level.shape.ravel()
    cut = inside & level.grid.outline.ravel()
    chosen = cut | (inside & ~np.isin(level.index, level.index[cut]))
    body, n = level.index[chosen], len(goal.scales)

    def sums(values: Complexes, of: Ints) -> Complexes:
        return np.asarray(np.bincount(of, values.real, n) + 1j * np.bincount(of, values.imag, n))

    counts = np.maximum(np.bincount(body, minlength=n), 1)
    anchor, there = sums(level.rest[chosen], body) / counts, sums(S[chosen], body) / counts
    turns = level.index[level.grid.quads[:, 0]]
    similar = linear_parts(level.grid, level.shape).similar.ravel()[turns >= 0]
    turn = np.where(held.free[:, TURN], np.exp(1j * np.angle(sums(similar, turns[turns >= 0]))), 1)
    stays = ~held.free[:, ALONG_X:].all(axis=1)
    size = _SEED
    for _ in range(_HALVINGS):
        alpha = goal.scales * turn * np.where(held.free[:, SCALE], size, 1)
        place = np.asarray(np.where(stays, goal.place, there + alpha * (held.pivots - anchor)), np.complex128)
        found = level.placed(S, np.asarray(alpha, np.complex128), place)
        if not count_folds(level, found.z):
            break
        size /= 2
    return found


def part_of_the_way(level: GridLevel, safe: Map, folded: Map) -> Map:
    """Return the map without folds that is as far on the way from `safe` to one that may fold as halving finds.

    A mean of two places of a body, but for its size, is one: bodies keep their shape on the way.
    """
    if not count_folds(level, folded.z):
        return folded
    best, done, beyond = safe, 0.0, 1.0
    for _ in range(_HALVINGS):
        share = (done + beyond) / 2
        ends = (safe.z, folded.z), (safe.alpha, folded.alpha), (safe.place, folded.place)
        z, alpha, place = (start + share * (end - start) for start, end in ends)
        size = np.abs(safe.alpha) ** (1 - share) * np.abs(folded.alpha) ** share
        found = level.placed(z, alpha * size / np.maximum(np.abs(alpha), np.finfo(float).tiny), place)
        if count_folds(level, found.z):
            beyond = share
        else:
            best, done = found, share
    return best
