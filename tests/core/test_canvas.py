"""The canvas holds the warped picture, and not a pixel more."""

import numpy as np
import pytest

from core.arrays import InputError, Points
from core.canvas import Canvas, has_gaps

FRAME = np.array([[[-0.5, -0.5], [9.5, -0.5]], [[-0.5, 5.5], [9.5, 5.5]]])


def test_an_unmoved_picture_keeps_its_frame() -> None:
    assert Canvas.around(FRAME) == Canvas(10, 6)
    assert Canvas.around(FRAME + 1e-9 * FRAME) == Canvas(10, 6)


def test_it_is_rounded_outwards_and_begins_at_zero() -> None:
    moved = FRAME + [-3.25, 100.5]
    canvas = Canvas.around(moved)
    assert canvas == Canvas(11, 7, (-4, 100))
    np.testing.assert_allclose(canvas.placed(moved)[0, 0], [0.25, 0.0])


def test_a_picture_without_extent_has_a_pixel() -> None:
    assert Canvas.around(FRAME * 0 + 3).size == (1, 1)


def test_sizes_that_no_picture_can_have_are_refused() -> None:
    with pytest.raises(InputError, match="output of 100000x10 pixels"):
        Canvas(100_000, 10)
    with pytest.raises(InputError, match="out of all bounds"):
        Canvas.around(FRAME * 1e12)


def grid(width: int, height: int, cells: int) -> Points:
    x, y = (np.linspace(-0.5, side - 0.5, cells + 1) for side in (width, height))
    return np.stack(np.meshgrid(x, y), axis=-1)


@pytest.mark.parametrize("size", [(1, 1), (1, 900), (300, 200), (2000, 1500)])
def test_a_covered_canvas_has_no_gaps(size: tuple[int, int]) -> None:
    nodes = grid(*size, 30)
    assert not has_gaps(nodes, size)
    assert not has_gaps(nodes + 0.3, size)
    assert not has_gaps(2 * nodes - size, size)
    assert not has_gaps(nodes[::-1], size)


def test_gaps_are_found_at_every_side_and_inside() -> None:
    nodes = grid(600, 400, 60)
    for motion in ([20, 0], [-20, 0], [0, 20], [0, -20], [1e12, 0]):
        assert has_gaps(nodes + motion, (600, 400))
    ring = grid(600, 400, 3)[[0, 1, 2, 3, 3, 3, 2, 1, 0, 0, 0], [0, 0, 0, 0, 1, 3, 3, 3, 3, 1, 0]]
    middle = ring.mean(axis=0)
    assert has_gaps(np.stack([ring, middle + 0.9 * (ring - middle)]), (600, 400))
