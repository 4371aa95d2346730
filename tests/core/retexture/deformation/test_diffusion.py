"""The deformation of the plane, and how fields on its grid are read."""

import numpy as np
import pytest

from core.retexture.deformation.coordinates import SpineCurves
from core.retexture.deformation.diffusion import Diffusion, compression, deformation, distortion
from tests.core.retexture.retexture_scenes import HEIGHT, WIDTH, arched, bent, straight

SHAPE = (HEIGHT, WIDTH)


def test_the_deformation_leads_from_the_target_curve_to_the_source_curve() -> None:
    grid, field = deformation(SHAPE, bent())
    t = np.linspace(0.8, straight().segments - 0.8, 50)
    target, source = bent()[0].target, bent()[0].source
    assert target is not None
    same = target.segments == source.segments
    s = t if same else source.parameter_at(target.length_at(t) / target.length * source.length)
    t = t if same else target.parameter_at(source.length_at(s) / source.length * target.length)
    np.testing.assert_allclose(target.at(t) + grid.at(field, target.at(t)), source.at(s), atol=0.3)


def test_the_deformation_is_harmonic_and_rests_at_the_border() -> None:
    grid, field = deformation(SHAPE, bent())
    assert not field[0].any()
    assert not field[-1].any()
    assert not field[:, 0].any()
    inner = field[1:-1, 1:-1]
    mean = (field[2:, 1:-1] + field[:-2, 1:-1] + field[1:-1, 2:] + field[1:-1, :-2]) / 4
    away = (
        SpineCurves([arched()]).distance(grid.nodes[1:-1, 1:-1].reshape(-1, 2)).reshape(inner.shape[:2]) > 2 * grid.step
    )
    np.testing.assert_allclose(inner[away], mean[away], atol=1e-9)


def test_nothing_moves_beyond_the_chosen_distance() -> None:
    grid, field = deformation(SHAPE, bent(), reach_px=30)
    far = SpineCurves([arched()]).distance(grid.nodes.reshape(-1, 2)).reshape(grid.rows, grid.columns) > 31
    assert not field[far].any()
    assert np.abs(field).max() > 20


def test_fields_are_read_the_same_everywhere() -> None:
    grid = Diffusion(SHAPE, np.array([[50.0, 50.0]]))
    linear = grid.nodes * [0.3, -2] + 1
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    want = np.stack([x * 0.3 + 1, y * -2.0 + 1], axis=-1)
    np.testing.assert_allclose(grid.at_pixels(linear), want, atol=1e-3)
    np.testing.assert_allclose(grid.at_pixels(linear, (slice(9, 30), slice(4, 99))), want[9:30, 4:99], atol=1e-3)
    np.testing.assert_allclose(grid.at(linear, np.array([[7.0, 3.0]])), want[3:4, 7], atol=1e-9)


def test_compression_is_clamped_and_distortion_is_that_of_the_map() -> None:
    grid = Diffusion(SHAPE, np.array([[50.0, 50.0]]))
    assert compression(grid, np.zeros((grid.rows, grid.columns, 2))) == pytest.approx(1)
    np.testing.assert_allclose(compression(grid, grid.nodes * [1.0, 0]), 2, atol=1e-9)
    np.testing.assert_allclose(compression(grid, grid.nodes * [9.0, 0]), 3)
    np.testing.assert_allclose(compression(grid, grid.nodes * [-0.6, 0]), 1, atol=1e-9)
    turned = grid.nodes @ np.array([[0.0, 1.0], [-1.0, 0.0]]) - grid.nodes
    np.testing.assert_allclose(compression(grid, turned), 1, atol=1e-9)
    np.testing.assert_allclose(distortion(grid, turned), 0, atol=1e-9)
    np.testing.assert_allclose(distortion(grid, grid.nodes * [1.0, 0]), np.log(2), atol=1e-9)
