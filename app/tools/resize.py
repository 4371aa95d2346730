"""The frame of the result, whose sides and corners are dragged to give it another size."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from app.editor.editor import Editor
from app.editor.tool import Tool
from app.marking.resizing import LABEL, Size, limit_size, propose_if_bare, with_size
from app.model.events import Move, Position, Press
from app.model.gestures import Gesture
from app.model.shapes import Polyline, Shape, Square
from app.model.spaces import move, screen_from_canvas
from app.tools.points.grips import REACH_PX, drag_from
from core.arrays import Points

GRIPS = np.array([(x, y) for y in (0.0, 0.5, 1.0) for x in (0.0, 0.5, 1.0) if (x, y) != (0.5, 0.5)])
"""Where the frame is gripped (8, 2), as shares of its width and height."""


def frame_on_screen(editor: Editor) -> tuple[Points, Points]:
    """Return the top left and the bottom right corner of the result (2,), in screen pixels."""
    size = np.array(editor.document.canvas_px, float)
    low, high = screen_from_canvas(editor.session.view, np.array([[-0.5, -0.5], size - 0.5]))
    return low, high


def grip_at(editor: Editor, pos: Position) -> int | None:
    """Return the number of the grip at a screen position: a corner, or anywhere on a side."""
    low, high = frame_on_screen(editor)
    away = np.hypot(*(low + GRIPS * (high - low) - pos).T)
    if away.min() <= REACH_PX:
        return int(np.argmin(away))
    inside = ((low - REACH_PX <= pos) & (pos <= high + REACH_PX)).all()
    sides = np.abs(np.array([pos[1] - low[1], pos[0] - low[0], pos[0] - high[0], pos[1] - high[1]]))
    number = int(np.argmin(sides))
    return (1, 3, 4, 6)[number] if inside and sides[number] <= REACH_PX else None


def press(editor: Editor, press: Press) -> Gesture | None:
    """Drag a side or a corner of the frame; what lies opposite stays where it is on the screen."""
    grip = grip_at(editor, press.pos)
    return None if grip is None else _drag(editor, press, grip)


def _drag(editor: Editor, press: Press, grip: int) -> Gesture:
    first = yield from drag_from(press.pos)
    if first is None:
        return
    start, view = editor.document, editor.session.view
    event: object = first
    try:
        with editor.group(LABEL):
            while isinstance(event, Move):
                by = np.subtract(event.pos, press.pos) / view.zoom
                size = _size(start.canvas_px, GRIPS[grip], by, locked=editor.session.resizing.locked ^ event.mods.shift)
                editor.document = with_size(start, limit_size(start, size))
                grown = np.subtract(editor.document.canvas_px, start.canvas_px) * view.zoom
                shift = np.where(GRIPS[grip] == 0.0, -grown, 0.0)
                resizing = replace(editor.session.resizing, dragged_px=editor.document.canvas_px)
                editor.show(view=move(view, (float(shift[0]), float(shift[1]))), resizing=resizing)
                event = yield
    except GeneratorExit:
        editor.show(view=view)
        raise
    propose_if_bare(editor)


def _size(start: Size, grip: Points, by: Points, *, locked: bool) -> Size:
    """Return what dragging a grip `by` (2,) pixels of the result makes of size `start`; `locked` keeps its ratio."""
    size = np.array(start, float)
    grown = size + np.where(grip == 1.0, by, np.where(grip == 0.0, -np.asarray(by), 0.0))
    if not locked:
        return float(grown[0]), float(grown[1])
    factors = (grown / size)[grip != 0.5]
    factor = float(max(factors[np.argmax(np.abs(factors - 1))], 0.01))
    return float(size[0] * factor), float(size[1] * factor)


def overlay(editor: Editor) -> Sequence[Shape]:
    """Draw the frame and its grips."""
    low, high = frame_on_screen(editor)
    corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    held = editor.session.hover
    grips = [
        Square((float(x), float(y)), 4.5, "hover" if number == held else "box", filled=True)
        for number, (x, y) in enumerate(low + GRIPS * (high - low))
    ]
    return [Polyline(corners, "box", closed=True), *grips]


RESIZE = Tool(
    name="resize",
    label="Resize",
    icon="up-right-and-down-left-from-center",
    key="f",
    hint="Drag a side or a corner of the frame: what is painted keeps its shape · Shift keeps the ratio",
    press=press,
    modes=frozenset(("warp",)),
    cursor="move",
    hover=grip_at,
    overlay=overlay,
)
