"""The inside follows the outline, and the outline goes where it is told."""

import numpy as np
import pytest

from core.arrays import InputError, Points
from core.warps.outline import follow_outline
from core.warps.presets import make_warp

CORNERS = np.array([[-0.5, -0.5], [79.5, -0.5], [79.5, 49.5], [-0.5, 49.5]])


def straight(corners: Points = CORNERS) -> Points:
    step = (np.roll(corners, -1, axis=0) - corners) / 3
    return np.stack([corners, corners + step, corners + 2 * step], axis=1).reshape(12, 2)


def nodes() -> Points:
    return np.stack(np.meshgrid(np.linspace(-0.5, 79.5, 17), np.linspace(-0.5, 49.5, 11)), axis=-1)


def test_straight_sides_are_the_identity() -> None:
    np.testing.assert_allclose(follow_outline(nodes(), straight()), nodes(), atol=1e-12)


def test_the_edge_lies_on_the_bezier_sides() -> None:
    ring = straight()
    ring[1:3] -= [0, 12]
    moved = follow_outline(make_warp("wave", 80, 50, bend=60)(nodes()), ring)
    # Both handles of a cubic raised by 12 raise its middle by 3/4 of that.
    np.testing.assert_allclose(moved[0, 8], [39.5, -9.5], atol=1e-9)
    np.testing.assert_allclose(moved[-1], nodes()[-1], atol=1e-9)


def test_sides_run_clockwise() -> None:
    ring = straight()
    ring[4] += [9, 0]  # the first handle of the right side, near its top
    moved = follow_outline(nodes(), ring)
    assert moved[3, -1, 0] > moved[-4, -1, 0] > 79.5


def test_similarities_of_the_outline_move_everything_alike() -> None:
    turn = np.array([[0.6, -0.8], [0.8, 0.6]]) * 1.5
    np.testing.assert_allclose(follow_outline(nodes(), straight() @ turn.T + 7), nodes() @ turn.T + 7, atol=1e-9)


def test_another_number_of_points_is_named() -> None:
    with pytest.raises(InputError, match="outline: needs 12 points"):
        follow_outline(nodes(), straight()[:11])
