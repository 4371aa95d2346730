"""When the canvas is drawn fast: while the picture moves, and to the end of a gesture that has moved it."""

from app.ui.canvas.scene import FOLDED_S, REST_S, Motion
from tests.app.driver import Clock, EditorDriver


def test_a_moved_view_is_a_draft_until_it_rests() -> None:
    clock, drive = Clock(), EditorDriver()
    motion = Motion(clock)
    motion.update(drive.editor)
    assert not motion.is_draft
    drive.tool("hand").press(10, 10).move(40, 10).release()
    motion.update(drive.editor)
    assert motion.is_draft
    assert motion.wait_s == REST_S
    clock.now += REST_S
    motion.update(drive.editor)
    assert not motion.is_draft
    assert motion.wait_s is None


def test_a_map_with_folds_is_drawn_at_its_best_later() -> None:
    clock, drive = Clock(), EditorDriver()
    motion = Motion(clock)
    motion.update(drive.editor)
    drive.tool("pins").press(60, 60).release().press(90, 60).release().press(60, 60).move(130, 60).release()
    motion.update(drive.editor)
    assert drive.editor.answer.folds
    assert motion.wait_s == FOLDED_S
    clock.now += REST_S
    motion.update(drive.editor)
    assert motion.is_draft
    clock.now += FOLDED_S
    motion.update(drive.editor)
    assert not motion.is_draft


def test_a_gesture_that_moved_the_picture_stays_a_draft_while_it_pauses() -> None:
    clock, drive = Clock(), EditorDriver()
    motion = Motion(clock)
    motion.update(drive.editor)
    drive.tool("pins").press(60, 60).release().press(60, 60).move(90, 80)
    while is_rough(drive):
        drive.frame()
    motion.update(drive.editor)
    clock.now += 10 * REST_S
    motion.update(drive.editor)
    assert motion.is_draft
    assert motion.wait_s is None
    drive.release()
    motion.update(drive.editor)
    assert not motion.is_draft


def is_rough(drive: EditorDriver) -> bool:
    """Return whether the next frame comes nearer to the final map."""
    result = drive.editor.answer.result
    return result is not None and result.is_rough


def test_a_stroke_that_moves_nothing_is_drawn_at_its_best() -> None:
    drive = EditorDriver()
    motion = Motion(Clock())
    motion.update(drive.editor)
    drive.tool("brush").press(60, 60).move(90, 80)
    motion.update(drive.editor)
    assert not motion.is_draft


def test_maps_that_say_the_same_are_the_same_arrays() -> None:
    drive = EditorDriver()
    motion = Motion(Clock())
    motion.update(drive.editor)
    rest, warped, folded = motion.rest, motion.warped, motion.folded
    drive.tool("brush").press(60, 60).move(90, 80).release()
    assert drive.editor.answer.warped is not warped
    assert drive.editor.answer.folded is not folded
    motion.update(drive.editor)
    assert motion.rest is rest
    assert motion.warped is warped
    assert motion.folded is folded
    assert folded is not None
