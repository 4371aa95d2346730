"""The canvas holds the warped picture, and not a pixel more."""

import numpy as np
import pytest

from core.arrays import InputError
from core.canvas import Canvas

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
