"""Cutting a thing out of the cloth along edges in the photo."""

import numpy as np
import pytest

from core.overlay.pixels.graph_cut import MOST, cut_out

NUMBERS = np.random.default_rng(0)
SIZE = (40, 50)
Y, X = np.indices(SIZE)
PHOTO = np.where((X > 21)[..., None], 0.7, 0.4) + NUMBERS.normal(0, 0.05, (*SIZE, 3))
DOUBTS = NUMBERS.normal(0, 0.4, SIZE)


@pytest.mark.parametrize("certain", [abs(X - 25) > 8, abs(X - 25) > 0, (X * Y) % 7 == 3, np.zeros(SIZE, np.bool_)])
def test_what_is_certain_is_no_node_and_cuts_the_same(certain: np.ndarray) -> None:
    side = np.where(X > 25, 1.0, -1.0)
    told, nearly = (cut_out(PHOTO, X < 60, np.where(certain, side * most, DOUBTS)) for most in (MOST, 0.99 * MOST))
    np.testing.assert_array_equal(told, nearly)
    np.testing.assert_array_equal(told[certain], (X > 25)[certain])


def test_all_may_be_certain() -> None:
    np.testing.assert_array_equal(cut_out(PHOTO, X < 60, np.where(X > 9, MOST, -MOST)), X > 9)


def test_the_outline_follows_the_edge_in_the_photo() -> None:
    cut = cut_out(PHOTO, X < 60, np.where(X < 12, -MOST, np.where(X > 32, MOST, 0.0)))
    assert np.abs(cut.argmax(1) - 22).max() <= 1
