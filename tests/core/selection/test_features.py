import numpy as np
import pytest

from core.arrays import InputError
from core.rasters.raster import Raster
from core.selection.features import (
    extend_numbers,
    free_number,
    number_area,
    only_marked,
    parts_of,
    split_along,
    without_numbered,
)


def square(left: int, right: int) -> np.ndarray:
    area = np.zeros((200, 300), bool)
    area[50:150, left:right] = True
    return area


def test_numbers_part_what_touches_and_join_what_does_not() -> None:
    mask = Raster.from_array(np.where(square(20, 100) | square(150, 200), 255, 0).astype(np.uint8))
    numbers = number_area(None, square(60, 100) | square(150, 200), 7)
    parts = parts_of(mask.array, numbers.array)
    assert set(np.unique(parts)) == {0, 7, 256}
    assert (parts[square(60, 100)] == 7).all()
    assert (parts[square(20, 60)] == 256).all()
    assert np.array_equal(without_numbered(mask, numbers).array > 0, square(20, 60))


def test_numbers_go_with_the_mask() -> None:
    numbers = number_area(None, square(20, 100), 3)
    mask = Raster.from_array(np.where(square(20, 50), 255, 0).astype(np.uint8))
    kept = only_marked(numbers, mask)
    assert kept is not None
    assert np.array_equal(kept.array == 3, square(20, 50))
    assert only_marked(numbers, Raster.filled(300, 200)) is None


def test_the_least_free_number_is_taken_and_there_are_255() -> None:
    assert free_number(None) == 1
    assert free_number(number_area(number_area(None, square(0, 9), 1), square(9, 18), 3)) == 2
    with pytest.raises(InputError, match="255"):
        free_number(Raster.from_array(np.arange(256, dtype=np.uint8)[None]))


def test_a_line_splits_an_area_and_no_pixel_is_lost() -> None:
    area = square(20, 100)
    left, right = split_along(area, np.array([[80.0, 20.0], [70.0, 180.0]]))
    assert not (left & right).any()
    assert np.array_equal(left | right, area)
    assert left.sum() > 1.5 * right.sum()
    assert left[100, 30]
    assert right[100, 95]


def test_a_line_that_ends_inside_splits_nothing() -> None:
    assert len(split_along(square(20, 100), np.array([[60.0, 20.0], [60.0, 100.0]]))) == 1


def test_what_is_marked_anew_has_the_number_of_the_nearest_feature() -> None:
    before = Raster.from_array(np.where(square(20, 100) | square(150, 200), 255, 0).astype(np.uint8))
    numbers = number_area(number_area(None, square(20, 100), 7), square(150, 200), 9)
    after = Raster.from_array(np.where(square(10, 220), 255, 0).astype(np.uint8))
    grown = extend_numbers(numbers, before, after).array
    assert np.array_equal(grown > 0, square(10, 220))
    assert (grown[square(10, 124)] == 7).all()
    assert (grown[square(126, 220)] == 9).all()
    assert extend_numbers(numbers, before, before) is numbers


def test_what_touches_a_feature_is_its_and_what_touches_none_is_nobodys() -> None:
    before = Raster.from_array(np.where(square(20, 100) | square(150, 200), 255, 0).astype(np.uint8))
    numbers = number_area(number_area(None, square(20, 100), 7), square(150, 200), 9)
    drawn = square(100, 140) | square(220, 260)
    after = Raster.from_array(np.where(drawn | (before.array > 0), 255, 0).astype(np.uint8))
    grown = extend_numbers(numbers, before, after, touching=True).array
    assert np.array_equal(grown == 7, square(20, 140))
    assert np.array_equal(grown == 9, square(150, 200))
