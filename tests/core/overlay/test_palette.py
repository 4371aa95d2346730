"""The few colours of a pattern."""

import numpy as np
import pytest

from core.overlay.palette import palette
from core.overlay.texel import Texel

COLOURS = np.array([[0.1, 0.2, 0.5], [0.8, 0.7, 0.6], [0.6, 0.1, 0.1]])


@pytest.mark.parametrize("side", [60, 480])
def test_the_colours_of_a_texel_are_found_however_many_samples_it_has(side: int) -> None:
    y, x = np.indices((side, side)) * 6 // side
    drawn = (2 * x + y) % 3
    pixels = COLOURS[drawn] + np.random.default_rng(0).normal(0, 0.01, (side, side, 3))
    found = palette(Texel(pixels), 3)
    away = np.linalg.norm(found[:, None] - COLOURS, axis=-1)
    assert sorted(away.argmin(1)) == [0, 1, 2]
    assert away.min(1).max() < 0.005


def test_each_number_of_colours_is_kept_by_itself() -> None:
    texel = Texel(np.random.default_rng(1).random((20, 20, 3)))
    assert [len(palette(texel, most)) for most in (2, 5, 2, 5)] == [2, 5, 2, 5]
    assert palette(texel, 5) is palette(texel, 5)
    np.testing.assert_array_equal(palette(texel, 2), palette(Texel(texel.pixels), 2))
