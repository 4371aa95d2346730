import numpy as np
import pytest

from app.actions.table import ActionTable
from app.model.session import Brush
from app.tools.all import TOOLS
from core import tracing
from tests.app.driver import EditorDriver, document

TABLE = ActionTable(TOOLS)


@pytest.fixture
def drive() -> EditorDriver:
    drive = EditorDriver(document().with_warp(preset="arch", bend=60.0))
    drive.editor.show(brush=Brush(diameter_px=20.0, hardness=1.0))
    return drive


def test_a_stroke_on_the_warped_picture_goes_on_where_it_was_begun_on_the_picture_as_it_was(
    drive: EditorDriver,
) -> None:
    view, place = drive.editor.session.view, drive.picture_at(100, 60)
    assert np.abs(place - (100, 60)).max() > 5
    drive.press(100, 60)
    assert drive.editor.unwarped.is_shown
    assert drive.picture_at(100, 60) == pytest.approx(place)
    drive.move(130, 60).move(130, 60).release()
    x, y = np.rint(place).astype(int)
    assert drive.mask[y, x] == drive.mask[y, x + 30] == 255
    assert drive.mask[y + 15, x] == 0
    assert drive.picture_at(100, 60) == pytest.approx(place)
    drive.tool("hand").frame()
    assert drive.editor.session.view == view
    assert not drive.editor.unwarped.is_shown


def test_the_brush_takes_the_picture_as_it_was_and_a_warp_shows_the_result(drive: EditorDriver) -> None:
    drive.tool("hand").tool("brush")
    assert drive.editor.unwarped.is_shown
    assert np.array_equal(drive.editor.answer.warped, drive.editor.answer.rest)
    drive.editor.edit("Twist", drive.document.with_warp(preset="twist"))
    drive.frame()
    assert not drive.editor.unwarped.is_shown
    drive.press(100, 60).release()
    assert drive.editor.unwarped.is_shown
    assert np.abs(drive.editor.map.warped - drive.editor.map.rest).max() > 5


def test_the_key_paints_on_the_result_as_it_is_seen(drive: EditorDriver) -> None:
    drive.tool("hand").tool("brush")
    TABLE.run("view.unwarped", drive.editor)
    assert not drive.editor.unwarped.is_shown
    place = np.rint(drive.picture_at(100, 60)).astype(int)
    drive.press(100, 60)
    assert not drive.editor.unwarped.is_shown
    drive.release()
    assert drive.mask[place[1], place[0]] == 255
    TABLE.run("view.unwarped", drive.editor)
    assert drive.editor.unwarped.is_shown


def test_an_unwarped_picture_is_painted_on_as_it_is() -> None:
    drive = EditorDriver()
    view = drive.editor.session.view
    drive.press(60, 60).release()
    assert not drive.editor.session.unwarped
    assert drive.editor.session.view == view


def test_both_sides_of_a_split_view_take_strokes(drive: EditorDriver) -> None:
    drive.tool("hand").tool("brush")
    drive.editor.show(compare="split", split=0.1)
    assert not drive.editor.unwarped.is_shown
    drive.press(60, 40).release()
    assert drive.mask[40, 60] == 255
    place = np.rint(drive.picture_at(100, 60)).astype(int)
    drive.press(100, 60).release()
    assert drive.mask[place[1], place[0]] == 255


def test_a_stroke_is_solved_once_the_warped_picture_is_looked_at(drive: EditorDriver) -> None:
    drive.rest().tool("brush")
    tracing.start()
    drive.press(60, 60).move(70, 60).move(80, 60).release()
    assert drive.editor.unwarped.is_shown
    assert not any(event["name"] == "answer" for event in tracing.events())
    TABLE.run("view.unwarped", drive.editor)
    drive.frame()
    assert drive.editor.map.document is drive.document
    assert len(drive.editor.map.result.features) == 1  # type: ignore[union-attr]


def test_a_stroke_is_solved_beside_the_window_once_the_hand_rests(drive: EditorDriver) -> None:
    drive.rest().tool("brush").press(60, 60).move(80, 60).release()
    tracing.start()
    drive.rest()
    assert [event["args"] for event in tracing.events() if event["name"] == "answer"] == [{"settled": True}]
    assert drive.editor.map.settled
    assert drive.editor.unwarped.is_shown


def test_a_warp_chosen_while_painting_is_answered_at_once(drive: EditorDriver) -> None:
    drive.rest().tool("brush").press(60, 60).move(80, 60).release()
    drive.editor.edit("Twist", drive.document.with_warp(preset="twist"))
    drive.frame()
    assert not drive.editor.unwarped.is_shown
    assert drive.editor.answer.document is drive.document
