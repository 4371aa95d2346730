from dataclasses import replace

import numpy as np
import pytest

from app.actions.table import ActionTable
from app.model.shapes import Bezier, Circle, Polyline
from app.tools.all import TOOLS
from app.tools.curves.curve_shapes import box_of
from app.tools.curves.curves import WARP_CURVES
from app.tools.marks import marks
from app.tools.points.box import MARGIN_PX
from core.arrays import Points
from core.curves import curve_edit
from core.curves.bezier import Curve
from core.document.curves import pairs as curve_pairs
from core.document.document import CurvePair, pixels_from_places
from tests.app.driver import EditorDriver


@pytest.fixture
def drive() -> EditorDriver:
    return EditorDriver().tool("curves")


def drawn(drive: EditorDriver) -> EditorDriver:
    """Draw a smooth curve of three knots."""
    drive.drag((40, 50), (50, 40)).drag((90, 50), (100, 60)).drag((140, 50), (150, 40))
    return drive.key("enter")


def target(drive: EditorDriver, number: int = 0) -> Points:
    return pixels_from_places(drive.document.canvas_px, drive.document.curves[number].target)


def source(drive: EditorDriver, number: int = 0) -> Points:
    return pixels_from_places(drive.document.size_px, drive.document.curves[number].source)


def test_a_knot_takes_the_picture_along(drive: EditorDriver) -> None:
    drawn(drive).drag((90, 50), (90, 70))
    assert np.allclose(target(drive)[3], (90, 70))
    assert np.allclose(target(drive)[2:5:2] - [(0, 20), (0, 20)], [(80, 40), (100, 60)])
    assert np.allclose(source(drive)[3], (90, 50))
    assert np.allclose(drive.screen_of(90, 50), (90, 70), atol=1.0)
    assert drive.labels == ("Draw curve", "Move curve point")


def test_several_knots_move_together_and_shift_holds_an_axis(drive: EditorDriver) -> None:
    drawn(drive).click(40, 50).click(140, 50, shift=True)
    assert drive.editor.session.selected_knots == {0, 2}
    drive.press(140, 50).move(143, 80, shift=True).release()
    assert np.allclose(target(drive)[::3], [(40, 80), (90, 50), (140, 80)])


def test_a_handle_of_a_smooth_knot_turns_the_other(drive: EditorDriver) -> None:
    drawn(drive).drag((100, 60), (90, 70))
    points = target(drive)
    assert np.allclose(points[4], (90, 70))
    assert np.allclose(points[2], (90, 50 - np.hypot(10, 10)))


def test_alt_breaks_a_smooth_knot(drive: EditorDriver) -> None:
    drawn(drive).press(100, 60, alt=True).move(90, 70, alt=True).release()
    points = target(drive)
    assert np.allclose(points[4], (90, 70))
    assert np.allclose(points[2], (80, 40))
    assert drive.document.curves[0].corners == {1}


def test_double_click_toggles_a_corner(drive: EditorDriver) -> None:
    drawn(drive).double_click(90, 50)
    assert drive.document.curves[0].corners == {1}
    assert drive.labels[-1] == "Make corner"
    drive.double_click(90, 50)
    assert drive.document.curves[0].corners == frozenset()


def test_a_corner_of_a_moved_target_leaves_its_source_as_it_is(drive: EditorDriver) -> None:
    drawn(drive)
    drawn_as = source(drive)
    drive.double_click(90, 50)
    assert not np.allclose(source(drive), drawn_as)
    assert np.allclose(source(drive), target(drive), atol=1e-6)
    drive.undo().drag((90, 50), (90, 80))
    before, moved = source(drive), target(drive)
    drive.double_click(90, 80)
    assert drive.document.curves[0].corners == {1}
    assert np.array_equal(source(drive), before)
    assert not np.allclose(target(drive), moved)


def test_a_click_on_the_line_inserts_and_delete_removes(drive: EditorDriver) -> None:
    drawn(drive)
    x, y = Curve(target(drive)).at(0.5)
    drive.click(float(x), float(y))
    assert curve_pairs.knots_of(drive.document.curves[0]) == 4
    assert np.allclose(target(drive)[3], (x, y), atol=0.5)
    assert np.allclose(source(drive), target(drive), atol=1e-6)
    drive.key("delete")
    assert curve_pairs.knots_of(drive.document.curves[0]) == 3
    assert drive.labels == ("Draw curve", "Insert curve point", "Remove curve point")


def test_a_drag_on_the_line_bends_it(drive: EditorDriver) -> None:
    drawn(drive)
    x, y = (float(v) for v in Curve(target(drive)).at(0.5))
    drive.drag((x, y), (x, y - 15))
    assert drive.labels[-1] == "Bend curve"
    _, away = Curve(target(drive)).nearest(np.array([[x, y - 15]]))
    assert away[0] < 0.5
    assert np.allclose(target(drive)[::3], [(40, 50), (90, 50), (140, 50)])
    before, centre, after = target(drive)[2:5]
    assert curve_edit.is_straight(before, centre, after)


def test_a_drag_at_a_knot_of_a_curve_that_is_not_in_hand_moves_it(drive: EditorDriver) -> None:
    drawn(drive).key("escape")
    drive.editor.show(selected_curve=None)
    drive.drag((93, 51), (93, 61), (93, 71))
    assert np.allclose(target(drive)[::3], [(40, 50), (90, 70), (140, 50)], atol=0.2)
    assert np.allclose(target(drive)[4] - target(drive)[3], (10, 10), atol=0.2)
    assert drive.editor.session.selected_curve == 0


def test_a_bend_beside_a_corner_leaves_the_other_side_of_it(drive: EditorDriver) -> None:
    drawn(drive).press(100, 60, alt=True).move(90, 70, alt=True).release()
    x, y = (float(v) for v in Curve(target(drive)).at(0.5))
    drive.drag((x, y), (x, y - 15))
    assert np.allclose(target(drive)[4], (90, 70))


def test_delete_without_a_selected_knot_removes_the_curve(drive: EditorDriver) -> None:
    drawn(drive).key("delete")
    assert drive.document.curves == ()
    assert drive.editor.session.selected_curve is None
    assert len(drive.undo().document.curves) == 1


def test_the_source_is_edited_apart_from_a_moved_target(drive: EditorDriver) -> None:
    drawn(drive).drag((90, 50), (90, 90))
    drive.editor.show(curve_side="source", selected_knots=frozenset())
    before = target(drive).copy()
    drive.drag((90, 50), (80, 45))
    assert np.allclose(source(drive)[3], (80, 45), atol=1e-6)
    assert np.allclose(source(drive)[0], (40, 50))
    assert np.array_equal(target(drive), before)


def test_handles_that_are_not_shown_are_not_gripped(drive: EditorDriver) -> None:
    drive.drag((40, 50), (40, 10)).drag((140, 50), (140, 90)).key("enter").key("a", ctrl=True)
    drive.drag((90, 40), (90, 100)).key("escape")
    assert np.allclose(target(drive)[1], (40, 70))
    before = drive.document
    drive.press(40, 10).move(50, 5)
    assert drive.document is before
    assert drive.editor.session.draft is not None
    drive.key("escape").editor.show(selected_curve=0)
    drive.drag((40, 70), (50, 65))
    assert np.allclose(target(drive)[1], (50, 65))
    drive.drag((40, 10), (50, 5), ctrl=True)
    assert np.allclose(source(drive)[1], (50, 5), atol=0.5)


def test_a_target_that_was_never_moved_goes_with_its_source(drive: EditorDriver) -> None:
    drawn(drive).move(90, 50, ctrl=True).press(90, 50, ctrl=True).move(90, 60, ctrl=True).release()
    assert np.allclose(source(drive)[3], (90, 60), atol=1e-6)
    assert np.allclose(target(drive)[3], (90, 60), atol=1e-6)


def test_the_box_of_all_points_holds_the_whole_curve(drive: EditorDriver) -> None:
    drive.drag((40, 80), (40, 20)).drag((140, 80), (140, 140)).key("enter").key("a", ctrl=True)
    box = box_of(drive.editor, WARP_CURVES)
    assert box is not None
    line = Curve(target(drive)).at(np.linspace(0, 1, 50))
    assert line[:, 1].min() < 60
    assert (box.low + MARGIN_PX <= line.min(axis=0) + 0.5).all()
    assert (box.high - MARGIN_PX >= line.max(axis=0) - 0.5).all()


def test_the_box_scales_a_curve(drive: EditorDriver) -> None:
    drawn(drive).key("a", ctrl=True)
    assert drive.editor.session.selected_knots == {0, 1, 2}
    drive.drag((154, 64), (104, 64))
    assert drive.labels[-1] == "Scale curve"
    assert np.ptp(target(drive)[::3, 0]) == pytest.approx(100 * 78 / 128)


def test_arrows_nudge_selected_knots_in_one_entry(drive: EditorDriver) -> None:
    drawn(drive).click(90, 50).key("down").key("down").key("right", shift=True)
    assert np.allclose(target(drive)[3], (100, 52))
    assert drive.labels == ("Draw curve", "Nudge curve points")


def test_a_rubber_band_selects_knots(drive: EditorDriver) -> None:
    drawn(drive).press(80, 20, shift=True).move(160, 80, shift=True).release()
    assert drive.editor.session.selected_knots == {1, 2}


def test_escape_deselects_step_by_step(drive: EditorDriver) -> None:
    drawn(drive).click(90, 50).key("escape")
    assert drive.editor.session.selected_knots == frozenset()
    assert drive.editor.session.selected_curve == 0
    drive.key("escape")
    assert drive.editor.session.selected_curve is None


def test_source_target_and_ticks_are_drawn(drive: EditorDriver) -> None:
    drawn(drive).drag((90, 50), (90, 90))
    shapes = drive.editor.tool.overlay(drive.editor)
    assert {s.role for s in shapes if isinstance(s, Bezier)} == {"source", "target"}
    assert any(isinstance(s, Polyline) and s.role == "tick" for s in shapes)
    drive.move(90, 91)
    assert any(isinstance(s, Circle) and s.role == "hover" for s in drive.editor.tool.overlay(drive.editor))


def test_ticks_stand_evenly_between_what_corresponds(drive: EditorDriver) -> None:
    drive.drag((20, 60), (70, 60)).drag((180, 60), (220, 60)).key("enter").key("a", ctrl=True)
    drive.drag((100, 62), (100, 112)).key("escape").move(20, 20)
    ticks = [s.points for s in marks(drive.editor) if isinstance(s, Polyline) and s.role == "tick"]
    assert len(ticks) >= 5
    assert np.allclose([tick[1] - tick[0] for tick in ticks], (0, 50), atol=1)
    steps = np.diff([tick[0][0] for tick in ticks])
    assert steps.min() >= 16
    assert steps.max() < 60


def test_the_hint_says_what_can_be_done_at_the_moment(drive: EditorDriver) -> None:
    tool = drive.editor.tool
    assert tool.moment(drive.editor) == ""
    drive.click(40, 50).move(80, 70)
    assert "close" in tool.moment(drive.editor)
    drive.click(80, 70).key("enter")
    assert "double-click" in tool.moment(drive.editor)
    drive.key("a", ctrl=True)
    assert "knob" in tool.moment(drive.editor)
    drive.key("escape").key("escape")
    assert tool.moment(drive.editor) == ""


def test_switched_off_curves_are_shown_while_one_is_dragged(drive: EditorDriver) -> None:
    drawn(drive)
    drive.editor.show(overlays=replace(drive.editor.session.overlays, handles=False, outline=False))
    assert marks(drive.editor) == []
    drive.press(90, 50).move(90, 60).move(90, 70)
    assert any(isinstance(s, Bezier) and s.role == "target" for s in marks(drive.editor))
    drive.release()


def test_a_curve_is_put_back_closed_and_opened_by_actions(drive: EditorDriver) -> None:
    table = ActionTable(TOOLS)
    assert not table.run("handles.put_back", drive.editor)
    drawn(drive).drag((90, 50), (90, 90))
    assert table.run("handles.put_back", drive.editor)
    assert np.allclose(target(drive), source(drive), atol=1e-6)
    assert table.run("handles.closed", drive.editor)
    assert drive.document.curves[0].closed
    assert table.run("handles.closed", drive.editor)
    assert not drive.document.curves[0].closed
    assert drive.labels[-3:] == ("Put curve back", "Close curve", "Open curve")


def test_a_closed_curve_is_opened_where_it_was_closed() -> None:
    points = np.random.default_rng(3).uniform(0, 1, (10, 2))
    pair = CurvePair(points, points + 0.1, corners=frozenset({1}))
    assert np.array_equal(curve_pairs.open_up(curve_pairs.close(pair)).source, pair.source)


def test_a_source_beside_the_picture_follows_the_nearest_place_on_it(drive: EditorDriver) -> None:
    drive.click(-30, 50).click(100, 50).key("enter")
    assert np.allclose(source(drive)[0], (-30, 50), atol=1e-6)
    assert WARP_CURVES.selected(drive.editor) == 0
