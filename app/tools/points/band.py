"""The rectangle that a drag spans to select what lies in it."""

from collections.abc import Callable

import numpy as np

from app.editor.editor import Editor
from app.model.events import Move, Position, Press
from app.model.gestures import Gesture
from app.model.shapes import Polyline, Shape


def span(editor: Editor, press: Press, take: Callable[[Position, Position], None]) -> Gesture:
    """Span a rectangle from the press on, and hand its corners to `take` whenever it changes."""
    try:
        while isinstance(event := (yield), Move):
            take(press.pos, event.pos)
            editor.show(band=(press.pos, event.pos))
    finally:
        editor.show(band=None)


def shapes(editor: Editor) -> list[Shape]:
    """Return the rectangle while there is one, to draw."""
    if editor.session.band is None:
        return []
    (left, top), (right, bottom) = editor.session.band
    corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
    return [Polyline(corners, "rubber-band", closed=True)]
