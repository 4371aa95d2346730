"""The deformation that is shown while a target is dragged."""

from itertools import pairwise

import numpy as np
import pytest

from core.arrays import Points
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.grid import Grid
from core.retexture.deformation.diffusion import Diffusion, deformation
from core.retexture.deformation.preview import NODES, LiveDeformation, Membrane, pull, space_out

HEIGHT, WIDTH = 150, 220


def line(*points: tuple[float, float]) -> Curve:
    """Return a straight line of one segment from the first to the last of two points."""
    first, last = np.array(points, float)
    return Curve(np.linspace(first, last, 4))


def laplacian(rows: int, columns: int) -> Points:
    """Return the graph Laplacian of a grid's nodes, dense, borders left out."""
    down, across = (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1) for n in (rows - 2, columns - 2))
    return np.kron(down, np.eye(columns - 2)) + np.kron(np.eye(rows - 2), across)


@pytest.mark.parametrize(("rows", "columns"), [(12, 19), (23, 9), (3, 3)])
def test_a_membrane_solves_the_equation_of_its_points(rows: int, columns: int) -> None:
    rng = np.random.default_rng(3)
    places = rng.uniform(0, [columns - 1, rows - 1], (25, 2))
    places[1] = places[0] + 1e-3
    places[2], places[3] = (1.0, 1.0), (0.0, 0.0)
    values, hold = rng.normal(size=(25, 2)), rng.uniform(10, 90, 25)
    cell = np.minimum(places.astype(int), [columns - 2, rows - 2])
    u, v = (places - cell).T
    read = np.zeros((25, rows, columns))
    for down in (0, 1):
        for right in (0, 1):
            weight = np.where(right, u, 1 - u) * np.where(down, v, 1 - v)
            read[np.arange(25), cell[:, 1] + down, cell[:, 0] + right] += weight
    inner = read[:, 1:-1, 1:-1].reshape(25, -1)
    matrix = laplacian(rows, columns) + inner.T @ (hold[:, None] * inner)
    expected = np.zeros((rows, columns, 2))
    expected[1:-1, 1:-1] = np.linalg.solve(matrix, inner.T @ (hold[:, None] * values)).reshape(rows - 2, columns - 2, 2)
    np.testing.assert_allclose(Membrane(rows, columns).hold(places, values, hold), expected, atol=1e-10)


@pytest.mark.parametrize("reach_px", [None, 40.0])
@pytest.mark.parametrize("by", [(0.0, 12.0), (70.0, 45.0)])
def test_what_is_shown_while_dragging_is_the_final_deformation(by: tuple[float, float], reach_px: float | None) -> None:
    source = line((40, 50), (120, 50))
    curves = [FeatureCurve(source, Curve(source.points + by))]
    nodes = Grid(WIDTH, HEIGHT, cell_px=5.0).nodes
    live = LiveDeformation((HEIGHT, WIDTH), nodes, reach_px=reach_px).solve(curves)
    final = pull(*deformation((HEIGHT, WIDTH), curves, reach_px=reach_px), nodes)
    # Where D is held to 0 beyond its reach, the outermost cells differ by how the limit falls on the nodes.
    most = 0.3 if reach_px is None else 2.0
    assert np.abs(live - final).max() < most
    assert np.abs(live - final).mean() < 0.01 * np.hypot(*by)
    assert np.abs(live - nodes).max() > 0.8 * max(by)


def test_the_feature_lies_on_its_target_however_far_it_was_dragged() -> None:
    source = line((40, 40), (90, 40))
    target = line((130, 120), (200, 100))
    nodes = Grid(WIDTH, HEIGHT, cell_px=1.0).nodes
    live = LiveDeformation((HEIGHT, WIDTH), nodes).solve([FeatureCurve(source, target)])
    t = np.linspace(0.1, 0.9, 20)
    at = np.rint(target.at(t)).astype(int)
    assert np.abs(live[at[:, 1], at[:, 0]] - source.at(t)).max() < 1.5


def test_a_still_a_passive_and_an_outer_curve_leave_the_picture_as_it_is() -> None:
    source = line((40, 50), (120, 50))
    outside = FeatureCurve(source, Curve(source.points + [0.0, 500.0]))
    nodes = Grid(WIDTH, HEIGHT, cell_px=5.0).nodes
    live = LiveDeformation((HEIGHT, WIDTH), nodes)
    for curves in ([], [FeatureCurve(source)], [FeatureCurve(source, source)], [outside]):
        np.testing.assert_allclose(live.solve(curves), nodes, atol=1e-9)


def test_a_long_curve_is_held_at_few_points_and_keeps_its_place() -> None:
    knots = np.array([(20 + 180 * (i % 2), 20 + 4 * i) for i in range(28)], float)
    pieces = [np.linspace(a, b, 4)[1:] for a, b in pairwise(knots)]
    target = Curve(np.concatenate([knots[:1], *pieces]))
    curves = [FeatureCurve(Curve(target.points + [3.0, -5.0]), target)]
    nodes = Grid(WIDTH, HEIGHT, cell_px=1.0).nodes
    live = LiveDeformation((HEIGHT, WIDTH), nodes).solve(curves)
    at = np.rint(target.at(np.linspace(0.5, 26.5, 60))).astype(int)
    assert np.abs(live[at[:, 1], at[:, 0]] - at - [3.0, -5.0]).max() < 1.0


@pytest.mark.parametrize("shape", [(495, 660), (3000, 4000), (614, 554)])
def test_the_live_grid_has_as_many_nodes_as_usual(shape: tuple[int, int]) -> None:
    cells = [int(np.ceil((side - 1) / space_out(shape))) for side in shape]
    assert 0.95 * NODES < cells[0] * cells[1] < 1.05 * NODES


def test_the_live_grid_of_a_small_picture_is_the_final_one() -> None:
    assert space_out((HEIGHT, WIDTH)) == Diffusion((HEIGHT, WIDTH), np.array([[50.0, 50.0]])).step
