"""Curvilinear coordinates along curves, and grids that follow them."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from core.curves.bezier import Curve
from core.retexture.deformation import coordinates
from core.retexture.deformation.coordinates import DirectionField, SpineCurves, trace, trace_roughly
from core.retexture.deformation.grids import fill, locate
from core.retexture.sampling import read
from core.retexture.synthesis.scene import near_curves
from tests.core.retexture.retexture_scenes import HEIGHT, WIDTH, arched, straight

SHAPE = (HEIGHT, WIDTH)


def ring(radius: float, centre: tuple[float, float]) -> Curve:
    """Return a circle of four segments, to a thousandth of its radius."""
    k = 0.5522847498 * radius
    r = radius
    points = [(r, 0), (r, k), (k, r), (0, r), (-k, r), (-r, k), (-r, 0), (-r, -k), (-k, -r), (0, -r), (k, -r), (r, -k)]
    return Curve(np.array([*points, points[0]], float) + centre, closed=True)


def test_feet_are_nearest_points_with_a_side() -> None:
    feet = SpineCurves([straight(100.0), straight(20.0)]).feet(np.array([[50.0, 110.0], [50.0, 90.0], [70.0, 25.0]]))
    np.testing.assert_array_equal(feet.curve, [0, 0, 1])
    np.testing.assert_allclose(feet.offset, [10, -10, 5], atol=1e-9)
    np.testing.assert_allclose(feet.length, [50, 50, 70], atol=1e-6)
    assert SpineCurves([straight(left=50)]).feet(np.array([[40.0, 100.0]])).beyond.all()


@settings(max_examples=25)
@given(st.floats(40, 60), st.floats(-15, 15), st.floats(0, 6.28))
@example(40.0, -15.0, 0.789)
def test_on_a_circle_spines_are_arcs_and_ribs_radii(radius: float, offset: float, angle: float) -> None:
    centre = np.array([110.0, 100.0])
    curves = SpineCurves([ring(radius, (110, 100))])
    field = DirectionField(curves, (0, 0, WIDTH, HEIGHT))
    r = radius + offset
    outward = np.array([np.cos(angle), np.sin(angle)])
    heading = np.array([-outward[1], outward[0]])
    grid = trace(field, (centre + r * outward)[None], heading[None], spine=10, rib=5)[0]
    distance = np.linalg.norm(grid - centre, axis=-1)
    # The circle runs clockwise on screen, so that its normal points inwards.
    want = r - np.arange(-5, 6)[:, None] + 0 * distance
    np.testing.assert_allclose(distance, want, atol=0.15)
    along = np.linalg.norm(np.diff(grid[5], axis=0), axis=-1)
    np.testing.assert_allclose(along, 1, atol=0.01)


def test_a_grid_that_would_fold_is_smoothed(monkeypatch: pytest.MonkeyPatch) -> None:
    curves = SpineCurves([ring(12, (110, 100))])
    field = DirectionField(curves, (0, 0, WIDTH, HEIGHT))
    origin, heading = np.array([[122.0, 100.0]]), np.array([[0.0, 1.0]])

    def folds(smoothing: float) -> int:
        monkeypatch.setattr(coordinates, "SMOOTHING", smoothing)
        grid = trace(field, origin, heading, spine=8, rib=16)
        assert np.linalg.norm(grid - origin, axis=-1).max() < 30
        along, across = np.diff(grid[0], axis=1)[:-1], np.diff(grid[0], axis=0)[:, :-1]
        return int((along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0] <= 0).sum())

    assert coordinates.SMOOTHING == 0.7
    assert folds(0.7) < 0.7 * folds(0.0)


def test_patches_stop_two_pixels_short_of_another_curve() -> None:
    kept = near_curves(SpineCurves([straight(60.0), straight(100.0)]), SHAPE)
    np.testing.assert_array_equal(np.flatnonzero(kept[:, 110] == 1), np.arange(58, 63))
    np.testing.assert_array_equal(np.flatnonzero(kept[:, 110] == 2), np.arange(98, 103))


def test_traces_keep_their_sense_between_curves_of_opposite_sense() -> None:
    curves = SpineCurves([straight(80.0), straight(120.0).reversed()])
    field = DirectionField(curves, (0, 0, WIDTH, HEIGHT))
    grid = trace(field, np.array([[100.0, 100.0]]), np.array([[1.0, 0.0]]), spine=10, rib=10)[0]
    np.testing.assert_allclose(grid[10], np.column_stack([np.arange(90, 111), np.full(21, 100)]), atol=1e-3)
    np.testing.assert_allclose(grid[:, 10], np.column_stack([np.full(21, 100), np.arange(90, 111)]), atol=1e-3)


def test_pixels_find_their_place_in_a_bent_grid() -> None:
    curves = SpineCurves([arched()])
    field = DirectionField(curves, (0, 0, WIDTH, HEIGHT))
    place, tangent = curves.place(np.zeros(1, int), np.array([100.0]), np.array([12.0]))
    rough = trace_roughly(field, place, tangent, spine=20, rib=12)
    grid = fill(rough, spine=20, rib=12)[0]
    corner = np.rint(place[0]).astype(int) - 26
    # Of two windows the second lies where only a part of the grid reaches.
    corners = np.stack([corner, corner + 30])
    number, pixel, at = locate(np.concatenate([rough, rough]), corners, 53, spine=20, rib=12)
    np.testing.assert_array_equal(number, np.sort(number))
    inside = (at > 0).all(axis=-1) & (at < [40, 24]).all(axis=-1)
    assert (inside & (number == 0)).sum() > 800
    assert 50 < (number == 1).sum() < 500
    pixel = np.stack([pixel % 53, pixel // 53], axis=-1) + corners[number]
    np.testing.assert_allclose(read(grid, at[inside][:, None])[:, 0], pixel[inside], atol=0.2)
    assert len(np.unique(pixel[number == 0], axis=0)) == (number == 0).sum()
