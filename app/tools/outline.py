"""The outline: the picture's edge as four Bezier sides, with corners and handles to drag."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.editor import Editor
from app.events import Event, Key, Move, Position, Press
from app.gestures import Gesture
from app.shapes import Bezier, Circle, Polyline, Shape, Square
from app.spaces import canvas_from_screen, screen_from_canvas
from app.tool import Tool
from app.tools.curve_set import place_on_line
from app.tools.grips import aimed, drag_from, nearest, nudge_px, places_from_screen, screen_from_places
from core import curve_edit
from core.arrays import Points
from core.document import Outline
from core.document_map import outline_of


@dataclass(frozen=True)
class Part:
    """What of the outline is gripped: a control point by its number in the ring, or a side by its parameter."""

    kind: Literal["corner", "handle", "side"]
    number: int = 0
    t: float = 0.0


def ring_on_screen(editor: Editor) -> Points:
    """Return the ring (13, 2) in screen pixels, closed."""
    ring = screen_from_places(editor, outline_of(editor.document).ring)
    return np.concatenate([ring, ring[:1]])


def part_at(editor: Editor, pos: Position) -> Part | None:
    """Return what of the outline is under `pos`; corners before handles before sides."""
    ring = ring_on_screen(editor)
    corner = nearest(ring[:-1:3], pos)
    if corner is not None:
        return Part("corner", 3 * corner)
    handles = np.array([number for number in range(12) if number % 3])
    handle = nearest(ring[handles], pos)
    if handle is not None:
        return Part("handle", int(handles[handle]))
    t = place_on_line(editor, canvas_from_screen(editor.session.view, ring), pos)
    return None if t is None else Part("side", t=t)


def press(editor: Editor, press: Press) -> Gesture | None:
    """Drag what is under the pointer; a double click straightens it."""
    part = part_at(editor, press.pos)
    if part is None:
        editor.show(selected_corner=None)
        return None
    if press.clicks > 1:
        straighten(editor, part)
        return None
    return drag(editor, press, part)


def drag(editor: Editor, press: Press, part: Part) -> Gesture:
    """Move a corner with its handles, a handle, or the gripped point of a side."""
    editor.show(selected_corner=part.number if part.kind == "corner" else None)
    start, ring = editor.document, ring_on_screen(editor)
    first = yield from drag_from(press.pos)
    if first is None:
        return
    with editor.group({"corner": "Move corner", "handle": "Move handle", "side": "Bend side"}[part.kind]):
        event: Event = first
        while isinstance(event, Move):
            shift = np.subtract(aimed(press.pos, event), press.pos)
            moved = _moved(ring, part, shift, broken=event.mods.alt)
            editor.document = start.changed(outline=Outline(places_from_screen(editor, moved[:-1])))
            event = yield


def _moved(ring: Points, part: Part, shift: Points, *, broken: bool) -> Points:
    """Return the ring with `part` moved by `shift`, on the screen; `broken` lets a smooth corner turn."""
    if part.kind == "corner":
        return curve_edit.with_knots_moved(ring, {part.number // 3}, shift, closed=True)
    if part.kind == "side":
        return curve_edit.bent(ring, part.t, shift)
    knot = curve_edit.knot_beside(ring, part.number, closed=True)
    before, after = curve_edit.handles_at(ring, knot, closed=True)
    smooth = (
        before is not None and after is not None and curve_edit.is_straight(ring[before], ring[3 * knot], ring[after])
    )
    place = ring[part.number] + shift
    return curve_edit.with_handle_at(ring, part.number, place, closed=True, linked=smooth and not broken)


def straighten(editor: Editor, part: Part) -> None:
    """Lay the handles of a corner, or those of the side, on the straight lines between corners."""
    outline = outline_of(editor.document)
    ring = np.concatenate([outline.ring, outline.ring[:1]])
    if part.kind == "corner":
        ring = curve_edit.cornered(ring, part.number // 3, closed=True)
    else:
        side = int(part.t) if part.kind == "side" else part.number // 3
        a, b = ring[3 * side], ring[3 * side + 3]
        ring[3 * side + 1 : 3 * side + 3] = [a + (b - a) / 3, a + (b - a) * 2 / 3]
    editor.edit("Straighten outline", editor.document.changed(outline=Outline(ring[:-1])))


def take_key(editor: Editor, key: Key) -> bool:
    """Nudge the corner that was gripped last."""
    corner, step = editor.session.selected_corner, nudge_px(key)
    if corner is None or step is None:
        return False
    outline = outline_of(editor.document)
    ring = np.concatenate([outline.ring, outline.ring[:1]])
    moved = curve_edit.with_knots_moved(ring, {corner // 3}, step / editor.canvas_px, closed=True)
    editor.edit("Nudge corner", editor.document.changed(outline=Outline(moved[:-1])), joins=True)
    return True


def hover(editor: Editor, pos: Position) -> object:
    """Return the part under the pointer."""
    return part_at(editor, pos)


def overlay(editor: Editor) -> Sequence[Shape]:
    """Draw sides, handles with their links, corners, and what is under the pointer."""
    ring = ring_on_screen(editor)
    shapes: list[Shape] = [Bezier(ring, "outline")]
    for number in range(12):
        place = (float(ring[number][0]), float(ring[number][1]))
        if number % 3 == 0:
            chosen = number == editor.session.selected_corner
            shapes.append(Square(place, 5.0, "knot-selected" if chosen else "corner", filled=True))
            continue
        corner = 3 * curve_edit.knot_beside(ring, number, closed=True)
        shapes.append(Polyline(ring[[corner, number]], "link"))
        shapes.append(Circle(place, 4.0, "handle", filled=True))
    part = editor.session.hover
    if isinstance(part, Part):
        at = _on_side(editor, ring, part.t) if part.kind == "side" else ring[part.number]
        if at is not None:
            shapes.append(Circle((float(at[0]), float(at[1])), 8.0, "hover"))
    return shapes


def _on_side(editor: Editor, ring: Points, t: float) -> Points | None:
    """Return the place of a side at parameter `t`, on the screen."""
    view = editor.session.view
    curve = curve_edit.curve_through(canvas_from_screen(view, ring))
    return None if curve is None else screen_from_canvas(view, curve.at(t))


OUTLINE = Tool(
    name="outline",
    label="Outline",
    icon="vector-square",
    key="o",
    hint="Drag corners, handles, sides · Shift holds an axis · Alt breaks smooth corners · double-click straightens",
    press=press,
    modes=frozenset(("warp",)),
    hover=hover,
    take_key=take_key,
    overlay=overlay,
)
