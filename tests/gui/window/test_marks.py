"""Lines over the picture, as they are sent to be drawn."""

from typing import Any

import numpy as np
import pytest

from app.model.shapes import Polyline
from app.ui.canvas.input import Area
from app.ui.canvas.marks import DASH_EM, GAP_EM, MOST_DASHES, MarkPainter
from app.ui.widgets import theme


class Sheet:
    """A draw list that keeps the lines of the widest stroke."""

    def __init__(self) -> None:
        self.lines: list[list[list[float]]] = []
        self.widest = 0.0

    def add_polyline(self, points: list[list[float]], code: int, width: float, flags: int) -> None:
        if width > self.widest:
            self.widest, self.lines = width, []
        if width == self.widest:
            self.lines.append(points)


def drawn(points: list[tuple[float, float]], *, dashed: bool, unit: float = 1.0) -> list[Any]:
    sheet = Sheet()
    painter = MarkPainter(sheet, Area(100, 50, 800, 600, unit))  # type: ignore[arg-type]
    painter.draw([Polyline(np.array(points), "pin", dashed=dashed)])
    return sheet.lines


@pytest.mark.parametrize("unit", [1.0, 2.0])
def test_dashes_go_around_corners_and_are_as_long_as_the_display_has_it(unit: float) -> None:
    (whole,) = drawn([(0, 0), (30, 0), (30, 40)], dashed=False, unit=unit)
    assert whole == [[100, 50], [100 + 30 * unit, 50], [100 + 30 * unit, 50 + 40 * unit]]
    dashes = drawn([(0, 0), (30, 0), (30, 40)], dashed=True, unit=unit)
    dash, step = unit * theme.TEXT_PX * DASH_EM, unit * theme.TEXT_PX * (DASH_EM + GAP_EM)
    assert len(dashes) == np.ceil(70 * unit / step)
    assert dashes[1] == [pytest.approx([100 + step, 50]), pytest.approx([100 + step + dash, 50])]
    assert np.hypot(*np.diff(dashes[-1], axis=0).T).sum() <= dash


def test_a_line_that_ends_beyond_all_pictures_has_so_many_dashes_and_no_more() -> None:
    assert len(drawn([(0, 0), (1e15, 0)], dashed=True)) == MOST_DASHES
