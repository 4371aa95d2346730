"""Handles that are dragged are answered in the same frame."""

import numpy as np
import pytest

from app.model.events import Move
from app.model.jobs import InlineExecutor, Jobs
from core.document.document import Document, Pin
from core.document.map_solver import MapSolver
from core.mapping.result import Warped
from tests.app.driver import EditorDriver, Later, document


def test_a_handle_in_a_free_frame_is_answered_in_the_same_frame() -> None:
    later = Later()
    free = document().with_warp(frame="free")
    drive = EditorDriver(free, jobs=Jobs(live=later, long=InlineExecutor())).tool("pins")
    later.run()
    drive.frame().press(60, 50)
    for x in range(70, 100, 10):
        drive.move(x, 50)
        assert np.allclose(drive.screen_of(60, 50), (x, 50), atol=1e-6)
    assert not later.waiting


def drag_the_source_of_a_curve(drive: EditorDriver, later: Later, *, off_px: float) -> None:
    """Draw a curve, move its target, and drag its source: every frame has its answer, so near to the target."""
    drive.frame().click(40, 60).click(100, 80).click(160, 60).key("enter").drag((100, 80), (100, 95))
    drive.editor.show(curve_side="source")
    drive.press(100, 80)
    for y in range(85, 92):
        drive.move(100, y)
        assert np.allclose(drive.screen_of(100, y), (100, 95), atol=off_px)
        assert drive.editor.answer.document.curves == drive.document.curves
    assert not later.waiting


def test_a_curve_drawn_and_moved_within_a_held_frame_is_answered_in_the_same_frame() -> None:
    later = Later()
    drive = EditorDriver(jobs=Jobs(live=later, long=InlineExecutor())).tool("curves")
    later.run()
    drag_the_source_of_a_curve(drive, later, off_px=0.5)


def test_a_curve_moved_within_a_free_frame_is_answered_in_the_same_frame() -> None:
    later = Later()
    free = document(cell_px=1.6).with_warp(frame="free")
    drive = EditorDriver(free, jobs=Jobs(live=later, long=InlineExecutor())).tool("curves")
    later.run()
    drag_the_source_of_a_curve(drive, later, off_px=0.5)
    drive.release().rest()
    later.run()
    drive.frame()
    assert drive.editor.answer.settled
    assert np.allclose(drive.screen_of(100, 91), (100, 95), atol=0.02)
    drive.editor.show(curve_side="target")
    drive.press(100, 95).move(104, 99)
    assert np.allclose(drive.screen_of(100, 91), (104, 99), atol=0.02)
    assert np.allclose(drive.editor.answer.warped, MapSolver().frame(drive.document).warped, atol=1e-6)
    assert not later.waiting


def test_all_moves_before_a_frame_cost_one_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    drive = EditorDriver().tool("pins").press(60, 50).move(80, 50)
    answered = []
    work = MapSolver.frame

    def counted(solver: MapSolver, document: Document) -> Warped:
        answered.append(document)
        return work(solver, document)

    monkeypatch.setattr(MapSolver, "frame", counted)
    for x in (82, 84, 85):
        drive.editor.handle(Move((x, 50)))
    drive.frame()
    assert len(answered) == 1
    assert np.allclose(drive.screen_of(60, 50), (85, 50), atol=1e-3)


def test_pins_on_one_spot_that_go_different_ways_meet_in_the_middle() -> None:
    pins = (Pin((0.5, 0.5), (0.6, 0.6)), Pin((0.5, 0.5), (0.3, 0.3)))
    drive = EditorDriver(document().changed(pins=pins))
    found = drive.editor.answer.result
    assert found is not None
    half = np.hypot(0.15 * 200, 0.15 * 150)
    assert [pin.error_px for pin in found.pin_reports] == pytest.approx([half, half])


def test_pins_take_the_picture_along_and_the_outline_stays() -> None:
    pins = (Pin((0.5, 0.5), (0.6, 0.55)),)
    drive = EditorDriver(document().changed(pins=pins))
    mesh = drive.editor.answer.mesh
    assert np.allclose(mesh.canvas_from_image(np.array([[99.5, 74.5]])), [[119.5, 82.0]], atol=1e-6)
    assert np.allclose(mesh.warped[0], mesh.grid.nodes[0])
