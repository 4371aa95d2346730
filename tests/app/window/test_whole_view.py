"""The picture stays in sight, and in the middle when it gets another size."""

import pytest

from app.actions.view import whole
from app.editor.editor import Editor
from app.model.spaces import View
from app.tools.all import TOOLS
from app.ui.canvas.whole_view import WholeView
from tests.app.driver import document


@pytest.fixture
def editor() -> Editor:
    editor = Editor(document(120, 80), TOOLS)
    editor.show(view=View(size=(900.0, 600.0)))
    editor.show(view=whole(editor))
    return editor


def test_a_new_size_is_shown_whole_and_in_the_middle(editor: Editor) -> None:
    follower = WholeView(editor)
    follower.update()
    before = editor.session.view
    editor.edit("Narrower", editor.document.with_warp(aspect=(0.5, 1.0)))
    follower.update()
    assert editor.session.view == whole(editor) != before


def test_a_part_that_was_chosen_stays_chosen(editor: Editor) -> None:
    follower = WholeView(editor)
    follower.update()
    near = whole(editor)
    editor.show(view=View(near.zoom * 3, near.pan, near.size))
    follower.update()
    view = editor.session.view
    editor.edit("Narrower", editor.document.with_warp(aspect=(0.5, 1.0)))
    follower.update()
    assert editor.session.view == view
