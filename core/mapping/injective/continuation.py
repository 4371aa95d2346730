"""The two parts of the way: clear folds, then let the barrier's weight fall.

Both are a schedule of Newton steps on one energy. Work is bounded by counting steps.
"""

import numpy as np

from core.mapping.injective.newton import take_step
from core.mapping.injective.problem import Problem
from core.mapping.tolerances import LITTLE, MET_PX
from core.progress import Job, Progress

HEAVY, HEAVIEST, ROOMY, LIGHT = 100.0, 1e5, 2.0, 0.1
"""μ while folds are cleared, at first and at most; where it has to leave room for a finer grid; and in the end."""
FALL, GENTLE_FALL = 0.2, 0.7
"""Fall of μ and of friction a step, and of μ where handles or the outline are drawn to their places on the way. Where
folds do not become shallower, μ rises by as much."""
_LAG, _SINK, _BLUNT, _SHARP, _SHARPEST = 0.5, 0.6, LITTLE, 1e-3, 1e-6
"""ε over the depth of the worst fold, and its fall a step at least; its least value while folds are cleared, at first
and in the end, and after that."""
_BRIEF, _PATIENCE, _SHALLOWER = 3, 7, 0.9
"""Steps within which the worst fold has to become a tenth shallower, or sizes and outline let go, or it has ended."""
ROOM = 0.02
"""Share of its area that every corner is to have before μ falls."""
STEPS, FEW_STEPS = 40, 12
"""Newton steps at most: to clear folds, or draw things to their places; and where folds are few, where μ falls, and
then for points that are not on their targets by then."""


def clear_folds(problem: Problem, steps: int = STEPS) -> Job[bool]:
    """Follow ε from the depth of the folds down, a little beyond the last one; return whether nothing folds any more.

    Where folds do not become shallower, sizes and outline let go; at last the barrier gains weight.
    """
    epsilon, floor, mu = np.inf, _BLUNT, HEAVY
    depths: list[float] = []
    problem.grip = mu
    if problem.is_stuck():
        return False
    for _ in range(steps):
        worst = problem.worst()
        if (worst > ROOM or (worst > 0 and len(depths) > 1 and min(depths[-2:]) > 0)) and is_met(problem):
            break
        stalled = [len(depths) >= n and worst < _SHALLOWER * depths[-n] for n in (1, _BRIEF, _PATIENCE)]
        if stalled[1] and problem.grip > 1 and can_give(problem):
            problem.grip, epsilon, depths = max(1.0, problem.grip * FALL), np.inf, []
        elif stalled[0] and -worst < 2 * floor and worst <= 0:
            floor, mu = max(floor / 2, _SHARP), mu / FALL
            if mu > HEAVIEST:
                break
        if stalled[2] and depths:
            break
        depths.append(worst)
        epsilon = max(floor, min(_LAG * max(-worst, 0), _SINK * epsilon))
        if not take_step(problem, mu, epsilon, clear=worst > 0):
            break
        yield Progress(0.0, "unfolding", work=problem.unknowns.count)
    return problem.worst() > 0


def is_met(problem: Problem) -> bool:
    """Return whether held points are on their targets."""
    return not problem.holds_points or bool(np.abs(problem.misses(problem.state)).max() < MET_PX)


def can_give(problem: Problem) -> bool:
    """Return whether there is anything that friction holds."""
    return bool(problem.unknowns.yields.any() or problem.unknowns.loose.size)


def relax(
    problem: Problem, mu: float = HEAVY, *, end: float = LIGHT, steps: int = FEW_STEPS, fall: float = FALL
) -> Job[None]:
    """Let μ fall to its `end`, and ε with √μ and friction with μ: the map comes to the least of E without a fold.

    Points that are not on their targets after so many steps get some more.
    """
    for step in range(steps + FEW_STEPS):
        if step >= steps and is_met(problem):
            break
        mu = max(mu * fall, end)
        problem.grip = max(1.0, problem.grip * FALL)
        # No blunter than the thinnest corner: it would not be felt before it folds.
        epsilon = max(_SHARPEST, min(_BLUNT * np.sqrt(mu / HEAVY), _LAG * problem.worst()))
        moved = take_step(problem, mu, epsilon, clear=True)
        yield Progress(0.0, "unfolding", work=problem.unknowns.count)
        if not moved or (mu <= end and moved < LITTLE and is_met(problem)):
            break
