"""The one stepper: projected Newton under the points' constraints, and a line search that lets nothing fold."""

from dataclasses import dataclass

import numpy as np

from core.arrays import Floats, SingularSystemError
from core.mapping.injective.problem import Model, Problem
from core.mapping.injective.unknowns import Iterate
from core.mapping.jacobians import Complexes
from core.mapping.tolerances import LITTLE

_STIFF, _ROUNDS = 1e4, 3
"""Weight of the points' rows over what else acts on their unknowns; each round meets them so many times closer."""
_SHORTEST, _LONGEST = 1e-4, 8.0
"""Lengths of steps that are tried; of the fall that its slope foretells a step has to bring as small a share."""
_MERIT = 2.0
"""Weight of the distance from constraints, over the greatest force that holds them, in the line search."""


@dataclass(frozen=True)
class Direction:
    """Newton's step, how E changes along it at first, and the greatest force (per pixel) that holds a point."""

    step: Floats
    slope: float
    force: float


def find_direction(problem: Problem, model: Model) -> Direction:
    """Minimise the model subject to C step = -c, for points that are held.

    With squares of the rows added, A = H + Cᵀ S C, the system is sparse and as easy to factorise as H; the multipliers
    y settle in a few substitutions, y <- y + S (C x + c) for A x = -g - Cᵀ (S c + y) (method of multipliers).
    """
    if not problem.holds_points:
        step = problem.factorise(model, np.empty(0)).solve(-model.gradient)
        return Direction(step, float(model.gradient @ step), 0.0)
    weight = _STIFF * problem.stiffness_at_points(model)
    factor = problem.factorise(model, weight)
    forces: Complexes = np.zeros(len(model.miss), np.complex128)
    step = np.zeros(problem.unknowns.count)
    for _ in range(_ROUNDS):
        step = factor.solve(-model.gradient - problem.against(model, weight * model.miss + forces))
        forces = forces + weight * (problem.along(model, step) + model.miss)
    return Direction(step, float(model.gradient @ step), float(np.abs(forces).max()))


def take_step(problem: Problem, mu: float, epsilon: float, *, clear: bool) -> float:
    """Take one Newton step, with `clear` one that folds nothing; return how far nodes moved, in cells, 0 for no step.

    Away from D = 0 the barrier bends far less than at it: the search goes on beyond 1 while the merit falls.
    """
    if not problem.unknowns.count:
        return 0.0
    model = problem.model(mu, epsilon)
    try:
        direction = find_direction(problem, model)
    except SingularSystemError:  # of corners so thin that their barrier is beyond double precision
        return 0.0
    price = _MERIT * direction.force
    before, worst = problem.energy(problem.state, mu, epsilon)
    least = LITTLE * worst if clear else -np.inf
    before += price * float(np.abs(model.miss).sum())
    slope = direction.slope - price * float(np.abs(model.miss).sum())
    length, best, lowest = 1.0, None, np.inf
    while _SHORTEST < length < _LONGEST:
        there = problem.unknowns.moved(problem.state, length * direction.step)
        merit = _merit(problem, there, mu, epsilon, price, least)
        lower = merit <= before + _SHORTEST * length * slope and merit < lowest
        if lower:
            best, lowest = there, merit
        if best is None:
            length /= 2
        elif lower and length >= 1:
            length *= 2
        else:
            break
    if best is None:
        return 0.0
    far = float(np.abs(best.z - problem.state.z).max() / problem.side)
    problem.state = best
    return far


def _merit(problem: Problem, state: Iterate, mu: float, epsilon: float, price: float, least: float) -> float:
    """Return E with the distance from constraints; infinity where a corner has no more than the least D."""
    energy, worst = problem.energy(state, mu, epsilon)
    if worst <= least or (least > -np.inf and problem.crosses_itself(state)):
        return np.inf
    return energy + price * float(np.abs(problem.misses(state)).sum()) if price else energy
