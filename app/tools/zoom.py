"""The magnifier: a click zooms in, with Alt out; a drag up and down zooms smoothly."""

from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.events import Move, Press
from app.model.gestures import Gesture
from app.model.spaces import zoom_at

CLICK_ZOOM = 2.0
DRAG_PX = 100.0
"""A drag of so many pixels up doubles the zoom."""
CLICK_PX = 3.0
"""The pointer must move farther than this to be a drag."""


def zoom(editor: Editor, press: Press) -> Gesture:
    """Zoom at the place of the press."""
    start = editor.session.view
    is_click = True
    while isinstance(event := (yield), Move):
        up = press.pos[1] - event.pos[1]
        is_click = is_click and abs(up) <= CLICK_PX
        if not is_click:
            editor.show(view=zoom_at(start, 2 ** (up / DRAG_PX), press.pos))
    if is_click:
        editor.show(view=zoom_at(start, 1 / CLICK_ZOOM if press.mods.alt else CLICK_ZOOM, press.pos))


ZOOM = Tool(
    name="zoom",
    label="Zoom",
    icon="magnifying-glass",
    key="z",
    hint="Click to zoom in, Alt-click to zoom out, drag up or down to zoom smoothly",
    press=zoom,
)
