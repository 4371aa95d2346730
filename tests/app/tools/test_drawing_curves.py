"""Curves are drawn with the pen."""

import numpy as np
import pytest

from app.model.shapes import Bezier, Circle
from core.document.curves import pairs as curve_pairs
from tests.app.driver import EditorDriver
from tests.app.tools.test_curves import drawn, source, target


@pytest.fixture
def drive() -> EditorDriver:
    return EditorDriver().tool("curves")


def test_the_pen_draws_in_one_entry(drive: EditorDriver) -> None:
    drawn(drive)
    assert drive.labels == ("Draw curve",)
    assert np.allclose(target(drive)[::3], [(40, 50), (90, 50), (140, 50)])
    assert np.allclose(target(drive)[1], (50, 40))
    assert np.allclose(target(drive)[2], (80, 40))
    assert np.allclose(source(drive), target(drive), atol=1e-6)
    assert drive.document.curves[0].corners == frozenset()
    assert drive.in_("curves.idle")


def test_while_it_is_drawn_it_is_a_draft(drive: EditorDriver) -> None:
    drive.click(40, 50).move(80, 70)
    assert drive.in_("curves.busy")
    assert drive.document is drive.start
    draft = drive.editor.session.draft
    assert draft is not None
    assert np.allclose(draft[::3], [(40, 50), (80, 70)])
    assert any(isinstance(s, Bezier) for s in drive.editor.tool.overlay(drive.editor))


def test_the_handles_that_are_pulled_out_are_shown(drive: EditorDriver) -> None:
    def handles() -> list[tuple[float, float]]:
        shapes = drive.editor.tool.overlay(drive.editor)
        return [shape.centre for shape in shapes if isinstance(shape, Circle) and shape.role == "handle"]

    drive.press(40, 50).move(50, 40)
    assert handles() == [(30, 60), (50, 40)]
    drive.release(50, 40)
    assert handles() == []
    drive.press(90, 50).move(100, 60, alt=True)
    assert handles() == [(100, 60)]
    drive.key("escape")
    assert drive.editor.session.draft_handles is None


def test_clicks_make_corners_with_handles_to_grip(drive: EditorDriver) -> None:
    drive.click(40, 50).click(100, 50).click(100, 110).key("enter")
    assert drive.document.curves[0].corners == {0, 1, 2}
    assert np.allclose(target(drive)[1:3], [(60, 50), (80, 50)])


def test_escape_leaves_no_trace_and_backspace_takes_one_back(drive: EditorDriver) -> None:
    drive.click(40, 50).click(100, 50).key("escape")
    assert drive.document is drive.start
    assert drive.editor.session.draft is None
    drive.click(40, 50).click(100, 50).click(120, 90).key("backspace").click(100, 110).key("enter")
    assert np.allclose(target(drive)[::3], [(40, 50), (100, 50), (100, 110)])


@pytest.mark.parametrize("end", ["escape", "enter"])
def test_a_click_beside_the_curve_that_comes_to_nothing_leaves_it_in_hand(drive: EditorDriver, end: str) -> None:
    drawn(drive).key("a", ctrl=True).click(40, 110).key(end)
    assert drive.labels == ("Draw curve",)
    assert drive.editor.session.selected_curve == 0
    assert drive.editor.session.selected_knots == {0, 1, 2}


def test_a_single_knot_is_no_curve(drive: EditorDriver) -> None:
    drive.click(40, 50).key("enter")
    assert drive.document is drive.start
    assert drive.in_("curves.idle")


def test_a_click_on_the_first_knot_closes(drive: EditorDriver) -> None:
    drive.click(40, 50).click(100, 50).click(70, 100).click(42, 51)
    pair = drive.document.curves[0]
    assert pair.closed
    assert curve_pairs.knots_of(pair) == 3
    assert np.array_equal(pair.target[0], pair.target[-1])
    assert drive.in_("curves.idle")


def test_a_double_click_or_a_change_of_tool_ends_the_curve(drive: EditorDriver) -> None:
    drive.click(40, 50).double_click(100, 50)
    assert len(target(drive)) == 4
    drive.click(40, 120).click(100, 120).tool("pins")
    assert len(drive.document.curves) == 2


def test_a_new_curve_changes_the_map_hardly_at_all(drive: EditorDriver) -> None:
    drive.editor.edit("Bend", drive.document.with_warp(preset="twist", bend=40))
    drive.frame()
    before = drive.editor.answer.warped
    drawn(drive)
    assert np.abs(drive.editor.answer.warped - before).max() < 0.5
    assert not np.allclose(source(drive), target(drive), atol=1)
