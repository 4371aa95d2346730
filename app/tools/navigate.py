"""The hand: drags the view."""

from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.events import Move, Press
from app.model.gestures import Gesture
from app.model.spaces import move


def drag_view(editor: Editor, press: Press) -> Gesture:
    """Move the view with the pointer."""
    start = editor.session.view
    while isinstance(event := (yield), Move):
        editor.show(view=move(start, (event.pos[0] - press.pos[0], event.pos[1] - press.pos[1])))


HAND = Tool(
    name="hand",
    label="Hand",
    icon="hand",
    key="h",
    hint="Drag to move the view; the wheel zooms at the pointer",
    press=drag_view,
    cursor="hand",
)
