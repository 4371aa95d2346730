"""The Newton problem of maps without folds: slopes, steps, points that glide."""

from dataclasses import replace

import numpy as np
import pytest

from core.grid import SIDES
from core.mapping.injective.levels import GridLevel, Transfer
from core.mapping.injective.newton import find_direction
from core.mapping.injective.outline import OutlineNodes
from core.mapping.injective.problem import Goal, Problem
from core.mapping.injective.unknowns import Freedoms
from core.mapping.jacobians import as_complex
from core.warps.presets import make_warp
from tests.core.mapping.test_injective import GRID, HEIGHT, REST, WIDTH, held_by, mapping_of, neighbours


def problem_with_everything(*, driven: bool) -> Problem:
    """Bodies, one about a pivot off its centre, gliding and loose outline nodes, points in quads that bodies share."""
    mapping = mapping_of(neighbours())
    at = np.array([[30.2, 40.1], [44.0, 90.3], [122.6, 80.0], [200.0, 20.0]])
    held = held_by(mapping, at, as_complex(at) + np.array([3, 2j, -1, 1 + 1j]))
    free, pivots = held.free.copy(), held.pivots.copy()
    free[0, 2:], free[1, :2], pivots[0] = False, False, 70 + 60j
    held = replace(held, free=free, pivots=pivots)
    w = as_complex(make_warp("flag", WIDTH, HEIGHT, bend=30)(GRID.nodes))
    start = mapping.place(w)
    level = GridLevel.of(mapping, w, start, w, held)
    centres = np.array([REST.ravel()[body.nodes].mean() for body in mapping.bodies])
    begin = level.of_solution(start, centres)
    coarse = Transfer(level, 2.0, held_outline=True)
    loose = np.zeros(coarse.coarse.grid.size, bool)
    loose[3:9] = True
    goal = Goal(1.1 * np.abs(start.alpha), start.alpha * np.exp(0.1j), begin.place + 4)
    freedoms = Freedoms(np.ones(len(start.alpha), bool), loose=loose, driven=~free if driven else None)
    return Problem(coarse.coarse, coarse.restrict_map(begin), goal, freedoms)


@pytest.mark.parametrize("driven", [False, True])
def test_slopes_are_those_of_the_energy_and_of_the_points(driven: bool) -> None:
    problem, random = problem_with_everything(driven=driven), np.random.default_rng(0)
    unknowns = problem.unknowns
    problem.state = unknowns.moved(problem.state, 0.05 * random.standard_normal(unknowns.count) / 60)
    mu, epsilon, h = 3.0, 0.5, 1e-5
    model = problem.model(mu, epsilon)
    special = np.unique(np.concatenate([unknowns.of_bodies[unknowns.active].ravel(), unknowns.of_nodes[:12].ravel()]))
    for i in [*special[special < unknowns.count], *random.integers(unknowns.count, size=20)]:
        step = np.zeros(unknowns.count)
        step[i] = h / (60 if i in unknowns.of_bodies[:, :2] else 1)
        ahead, behind = unknowns.moved(problem.state, step), unknowns.moved(problem.state, -step)
        slope = (problem.energy(ahead, mu, epsilon)[0] - problem.energy(behind, mu, epsilon)[0]) / (2 * step[i])
        assert slope == pytest.approx(model.gradient[i], rel=1e-4, abs=1e-5 * np.abs(model.gradient).max())
        along = (problem.misses(ahead) - problem.misses(behind)) / 2
        assert np.allclose(along, problem.along(model, step), rtol=1e-5, atol=1e-9)


def test_a_step_meets_points_to_first_order_and_goes_down_within_that() -> None:
    problem = problem_with_everything(driven=False)
    model = problem.model(1.0, 0.5)
    assert np.abs(model.miss).max() > 1
    found = find_direction(problem, model)
    assert np.abs(problem.along(model, found.step) + model.miss).max() < 1e-9
    # What forces on the points cannot hold is a descent: C (step - any step that meets them) = 0.
    other = find_direction(problem, replace(model, gradient=np.zeros_like(model.gradient))).step
    assert model.gradient @ (found.step - other) < 0


def test_gliding_nodes_stay_on_the_line_whatever_the_step() -> None:
    problem, random = problem_with_everything(driven=False), np.random.default_rng(1)
    moved = problem.unknowns.moved(problem.state, 0.3 * random.standard_normal(problem.unknowns.count))
    level = problem.level
    line, z = level.outline, moved.z[: level.grid.size].reshape(level.grid.shape)
    glide = level.constraints.glide & ~np.isin(np.arange(level.grid.size), problem.unknowns.loose).reshape(z.shape)
    assert glide.sum() > 100
    for number, side in enumerate(SIDES):
        on = z[side][glide[side]]
        assert np.abs(on - line.point_at(number, line.project(number, on))).max() < 1e-9
        assert np.abs(on - level.shape[side][glide[side]]).max() > 0.1


def test_points_of_a_line_are_found_again_by_arc_length() -> None:
    outline = OutlineNodes.of(as_complex(make_warp("arch", WIDTH, HEIGHT, bend=60)(GRID.nodes)))
    for side in range(4):
        arcs = np.linspace(0, outline.arcs[side][-1], 37)
        assert np.allclose(outline.project(side, outline.point_at(side, arcs)), arcs)
