"""A picture worked on some rows at a time."""

import numpy as np
import pytest

from core.overlay.filters.bands import PIXELS, ROWS, bands, in_bands


@pytest.mark.parametrize("shape", [(1, 1), (300, 512), (3000, 4000), (40, 300_000), (257, 0)])
@pytest.mark.parametrize("margin", [0, 1, 27])
def test_every_row_is_in_one_band_and_read_with_its_margin(shape: tuple[int, int], margin: int) -> None:
    times = np.zeros(shape[0], int)
    for first, top, bottom, last in bands(shape, margin):
        times[top:bottom] += 1
        assert first == max(top - margin, 0)
        assert last == min(bottom + margin, shape[0])
        assert bottom - top <= ROWS
    np.testing.assert_array_equal(times, 1)


def test_a_band_of_a_wide_picture_has_few_pixels_and_little_is_read_twice() -> None:
    narrow = next(bands((3000, 4000), 0))
    assert (narrow[2] - narrow[1]) * 4000 <= PIXELS
    margins = [(last - first) / (bottom - top) for first, top, bottom, last in bands((3000, 40_000), 9)]
    assert np.mean(margins) < 1.5


def test_what_comes_of_the_bands_is_in_their_order() -> None:
    picture = np.random.default_rng(0).random((700, 2000))
    sums = in_bands(lambda first, top, bottom, last: picture[top:bottom].sum(1), picture.shape)
    assert len(sums) > 4
    np.testing.assert_array_equal(np.concatenate(sums), picture.sum(1))


def test_a_fault_in_a_band_is_not_lost() -> None:
    def fail(first: int, top: int, bottom: int, last: int) -> None:
        raise ValueError(top)

    with pytest.raises(ValueError, match="0"):
        in_bands(fail, (300, 300))
