"""Pieces of one edge become one line; others do not."""

import cv2
import numpy as np
import pytest

from core.arrays import Points
from core.imaging.image import Image
from core.selection.collinear import join_collinear
from core.selection.long_lines import are_long, find_lines

ON = [[[0.0, 100.0], [90.0, 103.0]], [[130.0, 104.3], [200.0, 106.7]], [[215.0, 107.1], [300.0, 110.0]]]


def join(*lines: list[list[float]]) -> Points:
    return join_collinear(np.array(lines), 1.0, 20.0)


def test_pieces_on_one_line_are_one() -> None:
    for order in ([0, 1, 2], [2, 0, 1], [1, 2, 0]):
        assert join(*(ON[i] for i in order)) == pytest.approx(np.array([[[0, 100], [300, 110]]]))


@pytest.mark.parametrize(
    "other",
    [
        [[200.0, 106.7], [130.0, 104.3]],  # dark at the other hand
        [[130.0, 110.0], [200.0, 112.0]],  # beside it
        [[130.0, 104.0], [200.0, 125.0]],  # at an angle
        [[420.0, 114.0], [480.0, 116.0]],  # too far away
        [[95.0, 103.0], [110.0, 103.5]],  # too short
    ],
)
def test_others_stay_themselves(other: list[list[float]]) -> None:
    found = join(ON[0], other)
    assert len(found) == 2
    assert {tuple(line.ravel()) for line in found} == {tuple(np.ravel(ON[0])), tuple(np.ravel(other))}


def test_a_horizon_behind_trees_is_found_as_one_line() -> None:
    pixels = np.full((400, 600, 3), 200, np.uint8)
    cv2.fillPoly(pixels, [np.array([[0, 180], [599, 200], [599, 399], [0, 399]])], (70, 90, 60))
    for left in (120, 260, 430):
        pixels[120:300, left : left + 40] = (90, 60, 40)
    lines = find_lines(Image(pixels))
    horizon = [line for line in lines[are_long(lines, (600, 400))] if abs(np.diff(line[:, 1])[0]) < 40]
    assert len(horizon) == 1
    assert np.sort(horizon[0][:, 0]) == pytest.approx([-0.5, 599.5], abs=3)
