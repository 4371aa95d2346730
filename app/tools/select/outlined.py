"""Selections by a drawn outline: rectangle, ellipse, lasso and polygon."""

from collections.abc import Callable

import numpy as np

from app.editor.editor import Editor
from app.editor.painting import Side, side_at
from app.editor.tool import Tool
from app.marking.applying import choose_combining, select
from app.model.events import Event, Finish, Key, Modifiers, Move, Position, Press
from app.model.gestures import Gesture
from app.model.shapes import Shape
from app.tools.points.grips import REACH_PX, drag_from
from app.tools.select.places import GROUP, densely, outline_shapes, picture_places
from core.arrays import Points
from core.selection.combining import Combining
from core.selection.shapes import ellipse_outline, fill_polygon, rectangle_outline

LEAST_PX = 2.0
"""The lasso takes a place on its way when it is so far from the last one."""
WAYS = "Shift adds · Alt cuts out · both cross · Esc gives up"


def take_outline(editor: Editor, what: str, outline: Points, side: Side, how: Combining) -> None:
    """Select what lies inside an outline (n, 2) in screen pixels."""
    places = picture_places(editor, side, densely(outline))
    select(editor, what, fill_polygon(editor.document.size_px, places), how)


def square_corner(start: Position, pos: Position, mods: Modifiers) -> Position:
    """Return the corner of a box from `start` to `pos`: with Ctrl it is a square."""
    if not mods.ctrl:
        return pos
    across, down = pos[0] - start[0], pos[1] - start[1]
    side = max(abs(across), abs(down))
    return start[0] + float(np.copysign(side, across)), start[1] + float(np.copysign(side, down))


def drag_box(what: str, outline: Callable[[Points, Points], Points]) -> Callable[[Editor, Press], Gesture]:
    """Return the gesture that drags a box and selects what `outline` makes of its corners."""

    def press(editor: Editor, press: Press) -> Gesture:
        how, side, corner = choose_combining(editor, press.mods), side_at(editor, press.pos), press.pos
        event: Event | None = yield from drag_from(press.pos)
        try:
            while isinstance(event, Move):
                corner = square_corner(press.pos, event.pos, event.mods)
                editor.show(selection=outline(np.array(press.pos), np.array(corner)))
                event = yield
        finally:
            editor.show(selection=None)
        if corner != press.pos:
            take_outline(editor, what, outline(np.array(press.pos), np.array(corner)), side, how)

    return press


def lasso(editor: Editor, press: Press) -> Gesture:
    """Draw an outline freely; it closes when it is let go."""
    how, side, path = choose_combining(editor, press.mods), side_at(editor, press.pos), [press.pos]
    try:
        while isinstance(event := (yield), Move):
            if np.hypot(event.pos[0] - path[-1][0], event.pos[1] - path[-1][1]) >= LEAST_PX:
                path.append(event.pos)
                editor.show(selection=np.array(path))
    finally:
        editor.show(selection=None)
    if len(path) > 2:
        take_outline(editor, "lasso", np.array(path), side, how)


def polygon(editor: Editor, press: Press) -> Gesture:
    """Set a corner with each click until Enter, a double click, or a click on the first corner."""
    how, side, corners = choose_combining(editor, press.mods), side_at(editor, press.pos), [press.pos]
    try:
        while not closes(event := (yield), corners):
            if isinstance(event, Press):
                corners.append(event.pos)
            elif isinstance(event, Key):
                del corners[-1:]
                if not corners:
                    return
            tip = [event.pos] if isinstance(event, Move) else []
            editor.show(selection=np.array([*corners, *tip]))
    finally:
        editor.show(selection=None)
    if len(corners) > 2:
        take_outline(editor, "polygon", np.array(corners), side, how)


def closes(event: Event, corners: list[Position]) -> bool:
    """Return whether an event ends an outline that is clicked together."""
    if isinstance(event, Press):
        first = corners[0]
        is_first = len(corners) > 2 and np.hypot(event.pos[0] - first[0], event.pos[1] - first[1]) <= REACH_PX
        return bool(is_first or event.clicks > 1 or event.button == "right")
    return isinstance(event, Finish) or (isinstance(event, Key) and event.name == "enter")


def make_select_tool(
    name: str,
    label: str,
    icon: str,
    key: str,
    hint: str,
    press: Callable[..., Gesture | None],
    *,
    overlay: Callable[[Editor], list[Shape]] = outline_shapes,
) -> Tool:
    """Return a tool that selects; `overlay` draws what it draws."""
    return Tool(
        name=name,
        label=label,
        icon=icon,
        key=key,
        hint=hint,
        press=press,
        modes=frozenset(("warp", "retexture")),
        marks=True,
        group=GROUP,
        overlay=overlay,
    )


RECTANGLE = make_select_tool(
    "rectangle", "Select a rectangle", "square", "r", f"Drag a rectangle · Ctrl a square · {WAYS}",
    drag_box("rectangle", rectangle_outline),
)  # fmt: skip
ELLIPSE = make_select_tool(
    "ellipse", "Select an ellipse", "circle", "e", f"Drag an ellipse · Ctrl a circle · {WAYS}",
    drag_box("ellipse", ellipse_outline),
)  # fmt: skip
LASSO = make_select_tool("lasso", "Lasso", "draw-polygon", "l", f"Draw around something · {WAYS}", lasso)
POLYGON = make_select_tool(
    "polygon", "Polygon lasso", "shapes", "y",
    f"Click corner by corner · Backspace takes one back · Enter or the first corner closes · {WAYS}", polygon,
)  # fmt: skip
