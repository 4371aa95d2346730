"""The picture stays in sight, and in the middle when it gets another size."""

from dataclasses import replace

from app.actions.view import whole
from app.ui.canvas.whole_view import WholeView
from tests.app.driver import EditorDriver, document


def narrowed(drive: EditorDriver, follower: WholeView) -> None:
    follower.update()
    drive.editor.edit("Narrower", drive.document.with_warp(aspect=(0.5, 1.0)))
    drive.rest()
    follower.update()


def test_a_new_size_is_shown_whole_and_in_the_middle() -> None:
    drive = EditorDriver(document(120, 80))
    drive.editor.show(view=whole(drive.editor))
    before = drive.editor.session.view
    narrowed(drive, WholeView(drive.editor))
    after = drive.editor.session.view
    assert after == whole(drive.editor)
    left, right = (after.pan[0] + after.zoom * x for x in (-0.5, 59.5))
    assert abs(left + right - after.size[0]) < 2
    assert abs(before.pan[0] + before.zoom * 29.5 - after.size[0] / 2) > 50, "else it shows nothing"


def test_a_part_that_was_chosen_stays_chosen() -> None:
    drive = EditorDriver(document(120, 80))
    near = whole(drive.editor)
    drive.editor.show(view=replace(near, zoom=3 * near.zoom))
    view = drive.editor.session.view
    narrowed(drive, WholeView(drive.editor))
    assert drive.editor.session.view == view
