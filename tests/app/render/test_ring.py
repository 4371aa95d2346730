"""The ring of cells outside the outline."""

import numpy as np
import pytest

from app.render.passes.ring import MOST_RING_PX, RING_PX, put_ring
from core.arrays import Points

ROWS, COLUMNS = 4, 6


def with_ring(*grids: Points) -> list[Points]:
    """Return grids (R, C, 2) with the ring that the first has: (R + 2, C + 2, 2)."""
    ringed = [np.pad(grid, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan) for grid in grids]
    put_ring(*ringed)
    return ringed


def a_grid() -> Points:
    x, y = np.meshgrid(np.arange(COLUMNS) * 7.0, np.arange(ROWS) * 5.0)
    return np.stack([x, y], axis=-1)


@pytest.mark.parametrize("shear", [0.0, 0.8])
def test_the_ring_lies_so_many_pixels_across_the_outline(shear: float) -> None:
    A = np.array([[0.8, 0.6], [-0.6, 0.8]]) @ np.array([[1.0, shear], [0.0, 1.0]])
    moved = a_grid() @ A.T
    (ring,) = with_ring(moved)
    assert ring.shape == (ROWS + 2, COLUMNS + 2, 2)
    assert np.array_equal(ring[1:-1, 1:-1], moved)
    for side, along in ((ring[0, 1:-1] - moved[0], A[:, 0]), (ring[1:-1, -1] - moved[:, -1], A[:, 1])):
        across = np.abs(side[:, 0] * along[1] - side[:, 1] * along[0]) / np.hypot(*along)
        assert across == pytest.approx(np.full(len(side), RING_PX))


def test_an_outline_at_a_sharp_angle_has_a_short_ring() -> None:
    moved = a_grid() @ np.array([[1.0, 0.0], [30.0, 1.0]])
    (ring,) = with_ring(moved)
    assert np.hypot(*(ring[0, 1:-1] - moved[0]).T) == pytest.approx(np.full(COLUMNS, MOST_RING_PX))


def test_what_the_nodes_carry_goes_on_straight() -> None:
    rest = a_grid()
    A = np.array([[2.0, 0.5], [-0.3, 1.5]])
    moved = rest @ A.T + 3.0
    ring, carried = with_ring(moved, rest)
    assert carried @ A.T + 3.0 == pytest.approx(ring)


def test_nodes_on_one_spot_have_a_ring_without_holes_in_the_numbers() -> None:
    ring, carried = with_ring(np.zeros((3, 3, 2)), np.ones((3, 3, 2)))
    assert np.isfinite(ring).all()
    assert np.array_equal(carried, np.ones((5, 5, 2)))


def test_a_corner_of_the_ring_lies_beyond_both_of_its_sides() -> None:
    moved = a_grid() + np.random.default_rng(0).uniform(-2, 2, (ROWS, COLUMNS, 2))
    for ring, nodes in zip(with_ring(moved, a_grid()), (moved, a_grid()), strict=True):
        for down in (0, -1):
            for across in (0, -1):
                corner = nodes[down, across]
                beside = ring[down, 1 if across == 0 else -2] - corner, ring[1 if down == 0 else -2, across] - corner
                assert ring[down, across] - corner == pytest.approx(beside[0] + beside[1])
