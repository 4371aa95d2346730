"""Cloth carried straight on, into a gap and past its border."""

import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.pixels.extension import Layers, extend

SIZE = (60, 90)
Y, X = np.indices(SIZE).astype(float)
SLOPES = np.array([[0.05, 0.01], [-0.01, 0.06]])
AREA = 1 / abs(float(np.linalg.det(SLOPES)))
LEFT, RIGHT = X < 40, X > 52
"""Two sides of a gap."""
EVERYWHERE = np.ones(SIZE, bool)


def flat() -> Floats:
    return np.asarray(np.stack([X, Y], -1) @ SLOPES.T, np.float64)


def layers(uv: Floats, covered: Bools, rho: Floats | float = 1.0) -> Layers:
    return (
        np.where(covered[..., None], uv, np.nan).astype(np.float32),
        np.where(covered, rho, np.nan).astype(np.float32),
    )


def test_gap_goes_on_from_the_side_that_is_nearer() -> None:
    jump = np.where(RIGHT[..., None], [-1.3, 0.0], 0.0)
    uv, light = extend(layers(flat() + jump, LEFT | RIGHT, np.where(LEFT, 0.8, 1.2)), EVERYWHERE, AREA, 2.0)
    gap = ~(LEFT | RIGHT)
    nearer = np.where((X < 46)[..., None], 0.0, [-1.3, 0.0])
    away = np.abs(X - 46) > 1
    np.testing.assert_allclose(uv[gap & away], (flat() + nearer)[gap & away], atol=1e-4)
    np.testing.assert_allclose(light[gap & away], np.where(X < 46, 0.8, 1.2)[gap & away], atol=0.01)


def test_crushed_cloth_is_not_carried_on() -> None:
    uv, crushed = flat(), RIGHT & (X < 62)
    uv[crushed, 0] *= 6
    out, _ = extend(layers(uv, LEFT | RIGHT), EVERYWHERE, AREA, 2.0)
    np.testing.assert_allclose(out[30, 51], flat()[30, 51], atol=1e-3)
    np.testing.assert_array_equal(out[crushed], uv.astype(np.float32)[crushed])


def test_nothing_goes_on_from_no_cloth() -> None:
    none = layers(flat(), ~EVERYWHERE)
    uv, light = extend(none, EVERYWHERE, AREA, 4.0)
    assert np.isnan(uv).all()
    assert np.isnan(light).all()


@pytest.mark.parametrize("scale", [1, 2, 3])
def test_cloth_goes_on_past_its_border_where_it_is_wanted(scale: int) -> None:
    wanted = (X < 44) & (Y < 50)
    before = layers(flat(), LEFT)
    uv, light = extend(before, wanted, AREA / scale**2, 3.0, scale)
    np.testing.assert_allclose(uv[wanted & ~LEFT], flat()[wanted & ~LEFT], atol=1e-4)
    np.testing.assert_allclose(light[wanted & ~LEFT], 1.0, atol=1e-5)
    np.testing.assert_array_equal(np.isfinite(light), LEFT | wanted)
    np.testing.assert_array_equal(uv[LEFT], before[0][LEFT])
