"""Cloth carried straight on into a gap."""

import numpy as np

from core.arrays import Floats, Ints
from core.overlay.pixels.extension import extension_of

SIZE = (60, 90)
Y, X = np.indices(SIZE).astype(float)
SLOPES = np.array([[0.05, 0.01], [-0.01, 0.06]])
AREA = 1 / abs(float(np.linalg.det(SLOPES)))
LEFT, RIGHT = X < 40, X > 52
"""Two sides of a gap."""


def sides(jump: float) -> Floats:
    """Return coordinates on both sides, those of the right one moved by `jump` texels."""
    uv = np.asarray(np.stack([X, Y], -1) @ SLOPES.T, np.float64)
    uv[RIGHT, 0] += jump
    uv[~(LEFT | RIGHT)] = np.nan
    return uv


def owners() -> Ints:
    """Return the number of each side, -1 in the gap."""
    return np.where(LEFT, 0, np.where(RIGHT, 1, -1))


def test_gap_goes_on_from_the_side_that_is_nearer() -> None:
    rho = np.where(LEFT, 0.8, np.where(RIGHT, 1.2, np.nan))
    found = extension_of(sides(-1.3), rho, owners(), AREA, 4.0)
    assert found is not None
    places = np.array([[42.0, 20.0], [44.0, 31.0], [49.0, 20.0], [51.0, 40.0]])
    uv, light = found.at(places)
    expected = places @ SLOPES.T + np.array([[0, 0], [0, 0], [-1.3, 0], [-1.3, 0]])
    assert np.allclose(uv, expected, atol=1e-6)
    assert np.allclose(light, [0.8, 0.8, 1.2, 1.2], atol=0.01)


def test_crushed_cloth_is_not_carried_on() -> None:
    uv = sides(0.0)
    crushed = RIGHT & (X < 62)
    uv[crushed, 0] *= 6
    owner = np.where(crushed, 2, owners())
    found = extension_of(uv, np.where(owner >= 0, 1.0, np.nan), owner, AREA, 2.0)
    assert found is not None
    assert not crushed[found.places[:, 1].astype(int), found.places[:, 0].astype(int)].all()
    assert np.allclose(found.at(np.array([[51.0, 30.0]]))[0], np.array([51.0, 30.0]) @ SLOPES.T, atol=1e-6)


def test_nothing_goes_on_from_no_cloth() -> None:
    none = np.full(SIZE, np.nan)
    assert extension_of(np.stack([none, none], -1), none, np.full(SIZE, -1), AREA, 4.0) is None


def test_a_piece_that_explains_no_pixel_does_not_go_on() -> None:
    owner = np.where(RIGHT, 2, np.where(LEFT, 0, -1))
    assert extension_of(sides(0.0), np.where(owner >= 0, 1.0, np.nan), owner, AREA, 4.0) is not None
