import numpy as np
import pytest

from core.selection.combining import Combining, combine

BEFORE, SELECTED = np.array([[0, 255, 0, 255, 200]], np.uint8), np.array([[0, 0, 255, 255, 100]], np.uint8)


@pytest.mark.parametrize(
    ("how", "expected"),
    [
        ("replace", [0, 0, 255, 255, 100]),
        ("add", [0, 255, 255, 255, 200]),
        ("subtract", [0, 255, 0, 0, 155]),
        ("intersect", [0, 0, 0, 255, 100]),
    ],
)
def test_a_selection_meets_the_one_before(how: Combining, expected: list[int]) -> None:
    assert combine(BEFORE, SELECTED, how).tolist() == [expected]
