"""Lines over the picture, as they are sent to be drawn."""

from typing import Any

import numpy as np
import pytest
from imgui_bundle import imgui

from app.model.shapes import Circle, Polyline
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

    def path_arc_to(self, centre: imgui.ImVec2, radius: float, start: float, end: float) -> None:
        self.arc = [[centre.x + radius * np.cos(angle), centre.y + radius * np.sin(angle)] for angle in (start, end)]

    def path_stroke(self, code: int, width: float) -> None:
        self.add_polyline(self.arc, code, width, 0)


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


def test_a_dashed_circle_closes_with_whole_dashes() -> None:
    sheet = Sheet()
    MarkPainter(sheet, Area(100, 50, 800, 600, 2.0)).draw([Circle((30.0, 20.0), 40.0, "pin", dashed=True)])  # type: ignore[arg-type]
    ends = np.array(sheet.lines) - (100 + 2 * 30, 50 + 2 * 20)
    assert np.hypot(*np.moveaxis(ends, -1, 0)) == pytest.approx(np.full((len(ends), 2), 80.0))
    turns = np.diff(np.unwrap(np.arctan2(ends[..., 1], ends[..., 0]).ravel()))
    dashes, gaps = turns[::2], turns[1::2]
    assert dashes == pytest.approx(np.full(len(dashes), dashes[0]))
    assert gaps == pytest.approx(np.full(len(gaps), gaps[0]))
    assert len(ends) * (dashes[0] + gaps[0]) == pytest.approx(2 * np.pi)
    assert dashes[0] / gaps[0] == pytest.approx(DASH_EM / GAP_EM)
    assert dashes[0] * 80 == pytest.approx(2 * theme.TEXT_PX * DASH_EM, rel=0.05)
