from dataclasses import replace

import numpy as np
import pytest

from app.model.shapes import Circle, Polyline
from app.tools import pin_ring
from app.tools.pin_ring import RING_PX
from app.tools.pins import measure_miss_px, targets_on_screen
from app.tools.points.box import Box, Grip, apply
from core.document.document import Document, pixels_from_places
from core.document.ring import Ring
from core.rasters.raster import Raster
from tests.app.driver import EditorDriver, document
from tests.core.meshes import jacobians_of


@pytest.fixture
def drive() -> EditorDriver:
    return EditorDriver().tool("pins")


def bent() -> Document:
    """Return a document with two features whose linear answer folds."""
    mask = np.zeros((150, 200), np.uint8)
    mask[40:110, 60:95] = mask[40:110, 105:140] = 255
    start = document(cell_px=4.0).changed(mask=Raster.from_array(mask))
    return start.with_warp(preset="twist", bend=80, keep="rigid")


def targets(drive: EditorDriver) -> list[tuple[float, float]]:
    places = np.reshape([pin.to for pin in drive.document.pins], (-1, 2))
    return [(round(float(x), 6), round(float(y), 6)) for x, y in pixels_from_places(drive.document.canvas_px, places)]


def test_a_click_adds_and_changes_no_place(drive: EditorDriver) -> None:
    drive.click(60, 50)
    assert targets(drive) == [(60, 50)]
    assert drive.labels == ("Add pin",)
    assert np.allclose(drive.editor.answer.warped, drive.editor.answer.rest, atol=1e-6)


def test_a_drag_takes_the_picture_along_in_one_entry(drive: EditorDriver) -> None:
    drive.click(60, 50).drag((60, 50), (70, 52), (90, 60))
    assert targets(drive) == [(90, 60)]
    assert drive.labels == ("Add pin", "Move pin")
    assert np.allclose(drive.screen_of(60, 50), (90, 60), atol=1e-3)
    assert targets(drive.undo()) == [(60, 50)]


def test_press_and_drag_adds_and_moves_at_once(drive: EditorDriver) -> None:
    drive.drag((60, 50), (90, 60))
    assert drive.labels == ("Add pin",)
    assert np.allclose(drive.screen_of(60, 50), (90, 60), atol=1e-3)


def test_a_pin_sits_on_what_is_seen_under_the_pointer(drive: EditorDriver) -> None:
    drive.editor.edit("Bend", drive.document.with_warp(preset="twist", bend=60))
    drive.frame()
    x, y = drive.screen_of(60, 50)
    before = drive.editor.answer.warped
    drive.click(x, y)
    assert np.allclose(pixels_from_places((200, 150), np.array(drive.document.pins[0].at)), (60, 50), atol=1e-3)
    assert np.allclose(drive.editor.answer.warped, before, atol=1e-2)


def test_escape_while_dragging_leaves_no_trace(drive: EditorDriver) -> None:
    drive.click(60, 50)
    before = drive.document
    drive.press(60, 50).move(90, 60).key("escape").move(100, 100).release()
    assert drive.document is before
    assert drive.in_("pins.idle")


def test_a_click_on_a_pin_adds_none(drive: EditorDriver) -> None:
    drive.click(60, 50).click(63, 52)
    assert len(drive.document.pins) == 1
    assert drive.editor.session.selected == {0}


def test_alt_click_and_delete_remove(drive: EditorDriver) -> None:
    drive.click(60, 50).click(100, 80).click(60, 50, alt=True)
    assert targets(drive) == [(100, 80)]
    drive.click(100, 80).key("delete")
    assert targets(drive) == []
    assert drive.labels[-2:] == ("Remove pin", "Remove pin")


def test_shift_holds_an_axis(drive: EditorDriver) -> None:
    drive.click(60, 50).press(60, 50).move(75, 53, shift=True).release()
    assert targets(drive) == [(75, 50)]


def test_shift_selects_several_and_they_move_together(drive: EditorDriver) -> None:
    drive.click(60, 50).click(100, 80).click(140, 50)
    drive.click(60, 50).click(140, 50, shift=True)
    assert drive.editor.session.selected == {0, 2}
    drive.drag((60, 50), (65, 60))
    assert targets(drive) == [(65, 60), (100, 80), (145, 60)]
    drive.click(145, 60, shift=True)
    assert drive.editor.session.selected == {0}


def test_arrows_nudge_and_are_one_entry(drive: EditorDriver) -> None:
    drive.click(60, 50).key("right").key("right").key("down", shift=True)
    assert targets(drive) == [(62, 60)]
    drive.undo()
    assert targets(drive) == [(60, 50)]
    assert targets(drive.redo()) == [(62, 60)]


def test_a_rubber_band_selects(drive: EditorDriver) -> None:
    drive.click(60, 50).click(100, 80).click(140, 50)
    drive.press(50, 40, shift=True).move(110, 90, shift=True)
    assert any(isinstance(s, Polyline) and s.role == "rubber-band" for s in drive.editor.tool.overlay(drive.editor))
    drive.release()
    assert {0, 1} <= drive.editor.session.selected
    assert drive.editor.session.band is None
    drive.click(400, 400)
    assert drive.editor.session.selected == frozenset()
    assert len(drive.document.pins) == 3


def test_the_box_moves_scales_and_turns(drive: EditorDriver) -> None:
    drive.click(60, 50).click(140, 50).click(60, 110).click(140, 110).press(45, 35, shift=True)
    drive.move(160, 130, shift=True).release()
    assert len(drive.editor.session.selected) == 4
    drive.drag((100, 80), (110, 80))
    assert targets(drive)[0] == (70, 50)
    assert drive.labels[-1] == "Move pins"
    drive.drag((164, 124), (164 + 108 / 2, 124 + 88 / 2))
    assert targets(drive)[0][0] == pytest.approx(56 + 14 * 1.5)
    assert drive.labels[-1] == "Scale pins"
    corner = np.array(drive.editor.tool.overlay(drive.editor)[0].points)[2]  # type: ignore[union-attr]
    drive.press(*(corner + 12)).move(corner[0] - 200, corner[1] + 5).release()
    assert drive.labels[-1] == "Turn pins"


def test_the_hovered_pin_is_marked(drive: EditorDriver) -> None:
    drive.click(60, 50).move(62, 50)
    assert any(isinstance(s, Circle) and s.role == "hover" for s in drive.editor.tool.overlay(drive.editor))
    drive.move(90, 90)
    assert not any(isinstance(s, Circle) and s.role == "hover" for s in drive.editor.tool.overlay(drive.editor))


def test_two_pins_make_an_exact_turn_where_the_frame_is_free(drive: EditorDriver) -> None:
    drive.editor.edit("Free", drive.document.with_warp(frame="free"))
    drive.click(60, 75).click(140, 75).drag((140, 75), (100, 155)).drag((60, 75), (100, 75))
    jacobians = jacobians_of(drive.editor.answer.mesh, np.array([[20.0, 20.0], [180.0, 130.0]]))
    assert np.allclose(jacobians, [[0, -1], [1, 0]], atol=1e-3)


def test_a_grip_of_the_box_in_numbers() -> None:
    box = Box(np.array([0.0, 0.0]), np.array([100.0, 50.0]))
    assert box.grip((50, 25)) == Grip("move")
    assert box.grip((101, 51)) == Grip("scale", 2)
    assert box.grip((115, 60)) == Grip("turn", 2)
    knob = box.grip((53, -25))
    assert knob is not None
    assert knob.kind == "turn"
    assert np.allclose(apply(box.transform(knob, (50, -24), (99, 25), held=False), np.array([[50.0, 0.0]])), (75, 25))
    assert box.grip((300, 300)) is None
    scaled = box.transform(Grip("scale", 2), (100, 50), (200, 50), held=False)
    assert np.allclose(apply(scaled, np.array([[0.0, 0.0], [50.0, 50.0]])), [[0, 0], [100, 50]])
    turned = box.transform(Grip("turn", 1), (100, 25), (50, 75), held=False)
    assert np.allclose(apply(turned, np.array([[100.0, 25.0]])), [[50, 75]])


def faulty_lines(drive: EditorDriver) -> list[Polyline]:
    shapes = drive.editor.tool.overlay(drive.editor)
    return [shape for shape in shapes if isinstance(shape, Polyline) and shape.role == "faulty"]


def test_a_line_leads_from_a_pin_that_cannot_be_met_to_its_point() -> None:
    drive = EditorDriver().tool("pins").click(60, 50).drag((60, 50), (400, 50)).rest()
    found = drive.editor.answer
    assert found.settled
    assert not found.folds
    (line,) = faulty_lines(drive)
    assert line.points[0] == pytest.approx(targets_on_screen(drive.editor)[0])
    assert line.points[1] == pytest.approx(drive.screen_of(60, 50), abs=1e-6)
    assert measure_miss_px(drive.editor, 0) > 200
    drive.editor.live.answer = replace(found, settled=False)
    assert measure_miss_px(drive.editor, 0) == 0, "a map that is not the final one has missed nothing yet"
    drive.editor.live.answer = found
    drive.drag((400, 50), (70, 55)).rest()
    assert measure_miss_px(drive.editor, 0) == 0
    assert not faulty_lines(drive)


def test_a_pin_that_is_set_on_a_bent_picture_with_features_changes_no_bit() -> None:
    drive = EditorDriver(bent()).rest()
    before = drive.editor.answer.warped
    drive.tool("pins").click(70, 60).click(120, 80).rest()
    assert len(drive.document.pins) == 2
    assert np.array_equal(drive.editor.answer.warped, before)


def ring_of(drive: EditorDriver, number: int = 0) -> Ring:
    ring = drive.document.pins[number].ring
    assert ring is not None
    return ring


def turned(drive: EditorDriver, x: float, y: float) -> complex:
    """Return by how much handles have turned and scaled the picture around a place of it."""
    assert drive.editor.answer.result is not None
    return complex(drive.editor.answer.result.turned_at(np.array([[x, y]]))[0])


def test_a_dragged_ring_turns_and_scales_the_picture_in_one_entry(drive: EditorDriver) -> None:
    drive.click(100, 75).drag((100, 75 - RING_PX), (100 + 0.8 * RING_PX, 60), (100 + 1.2 * RING_PX, 75))
    assert drive.labels == ("Add pin", "Turn and scale pin")
    assert (ring_of(drive).turn_deg, ring_of(drive).scale) == pytest.approx((90, 1.2))
    assert turned(drive, 100, 75) == pytest.approx(1.2j, abs=1e-3)
    assert np.allclose(drive.screen_of(100, 75), (100, 75), atol=1e-3)
    drive.undo()
    assert drive.document.pins[0].ring is None
    assert np.allclose(drive.editor.answer.warped, drive.editor.answer.rest, atol=1e-6)


def test_with_shift_a_ring_turns_by_whole_steps_and_keeps_its_scale(drive: EditorDriver) -> None:
    drive.click(100, 75).press(100 + RING_PX, 75).move(100 + RING_PX, 75 + 0.5 * RING_PX, shift=True).release()
    assert ring_of(drive).turn_deg == pytest.approx(30)
    assert ring_of(drive).scale == 1


def test_a_ring_begins_with_the_turn_that_other_handles_gave(drive: EditorDriver) -> None:
    drive.click(80, 75).click(120, 75).drag((120, 75), (115, 100))
    drive.click(100, 40)
    x, y = pixels_from_places((200, 150), np.array(drive.document.pins[2].at))
    there, before = turned(drive, x, y), drive.editor.answer.warped
    assert abs(np.degrees(np.angle(there))) > 1
    shown = pin_ring.find_ring(drive.editor, 2)
    assert (shown.turn_deg, shown.scale) == pytest.approx((np.degrees(np.angle(there)), abs(there)))
    drive.editor.document = pin_ring.with_ring(drive.document, 2, shown)
    drive.frame()
    assert np.abs(drive.editor.answer.warped - before).max() < 0.1


def test_an_alt_click_on_a_ring_takes_it_off_and_leaves_the_pin(drive: EditorDriver) -> None:
    drive.click(100, 75).drag((100, 75 - RING_PX), (100 + RING_PX, 75))
    drive.click(100, 75 + RING_PX, alt=True)
    assert drive.document.pins[0].ring is None
    assert drive.labels[-1] == "Remove ring"
    assert len(drive.document.pins) == 1


def test_a_ring_that_cannot_be_met_is_reported(drive: EditorDriver) -> None:
    mask = np.zeros((150, 200), np.uint8)
    mask[50:100, 70:130] = 255
    rigid = document(cell_px=4.0).changed(mask=Raster.from_array(mask)).with_warp(keep="rigid")
    drive = EditorDriver(rigid).tool("pins").click(100, 75)
    drive.drag((100 + RING_PX, 75), (100 + 2 * RING_PX, 75)).rest()
    assert ring_of(drive).scale == pytest.approx(2)
    (report,) = drive.editor.answer.pins
    assert report.ring is not None
    assert report.ring.reached_scale == pytest.approx(1)
    assert measure_miss_px(drive.editor, 0) == pytest.approx(report.ring.error_px) != 0


def test_a_click_on_the_ring_of_the_selected_pin_adds_a_pin_there(drive: EditorDriver) -> None:
    drive.tool("pins").press(60, 60).release().press(60 + RING_PX, 60).release()
    assert len(drive.document.pins) == 2
    assert all(pin.ring is None for pin in drive.document.pins)
    drive.editor.undo()
    assert len(drive.document.pins) == 1


def test_a_click_on_the_knob_of_a_ring_adds_nothing(drive: EditorDriver) -> None:
    drive.tool("pins").press(60, 60).release().press(60, 60 - RING_PX).move(61, 60 - RING_PX).release()
    assert len(drive.document.pins) == 1
    assert drive.document.pins[0].ring is None
