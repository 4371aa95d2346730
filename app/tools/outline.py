"""The outline: the picture's edge as four Bezier sides, with corners and handles to drag."""

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.events import Event, Key, Move, Position, Press
from app.model.gestures import Gesture
from app.model.shapes import Bezier, Circle, Polyline, Shape, Square
from app.model.spaces import canvas_from_screen, screen_from_canvas
from app.tools import outline_aids
from app.tools.curves.curve_set import place_on_line
from app.tools.outline_aids import Snapping
from app.tools.points import band
from app.tools.points.box import Box, Grip, apply
from app.tools.points.grips import drag_from, nearest, nudge_px, places_from_screen, screen_from_places
from app.tools.points.selection import Selection
from core.arrays import InputError, Points
from core.curves import curve_edit
from core.document import perspective
from core.document.document import Document, Outline
from core.document.map import outline_of

CORNERS = 4


@dataclass(frozen=True)
class OutlinePart:
    """What of the outline is gripped: a control point by its number in the ring, or a side by its parameter."""

    kind: Literal["corner", "handle", "side"]
    number: int = 0
    t: float = 0.0


def find_outline(editor: Editor) -> Outline:
    """Return the document's outline; while it has no map, that of the picture on the screen, which has the last one."""
    for document in (editor.document, editor.answer.document):
        with contextlib.suppress(InputError):
            return outline_of(document)
    return Outline.straight()


def ring_on_screen(editor: Editor) -> Points:
    """Return the ring (13, 2) in screen pixels, closed."""
    ring = screen_from_places(editor, find_outline(editor).ring)
    return np.concatenate([ring, ring[:1]])


def part_at(editor: Editor, pos: Position) -> OutlinePart | None:
    """Return what of the outline is under `pos`; corners before handles before sides."""
    ring = ring_on_screen(editor)
    corner = nearest(ring[:-1:3], pos)
    if corner is not None:
        return OutlinePart("corner", 3 * corner)
    handles = np.array([number for number in range(12) if number % 3])
    handle = nearest(ring[handles], pos)
    if handle is not None:
        return OutlinePart("handle", int(handles[handle]))
    t = place_on_line(editor, canvas_from_screen(editor.session.view, ring), pos)
    return None if t is None else OutlinePart("side", t=t)


def find_selected(editor: Editor) -> frozenset[int]:
    """Return the numbers of the selected corners, 0 to 3 clockwise from the top left."""
    return editor.session.selected_corners


SELECTION = Selection("selected_corners", find_selected)


def box_of(editor: Editor) -> Box | None:
    """Return the box around the selected corners if they are several; all four have the whole outline in it."""
    ring, corners = ring_on_screen(editor), sorted(find_selected(editor))
    return Box.around(curve_edit.samples_of(ring) if len(corners) == CORNERS else ring[[3 * n for n in corners]])


def press(editor: Editor, press: Press) -> Gesture | None:
    """Drag what is under the pointer, or the box, or select; a double click straightens."""
    part, box = part_at(editor, press.pos), box_of(editor)
    grip = box.grip(press.pos) if box is not None else None
    if part is not None and press.clicks > 1:
        straighten(editor, part)
        return None
    if part is not None and part.kind == "corner":
        return drag_corners(editor, press, part.number // 3)
    if box is not None and grip is not None and (part is None or (part.kind == "side" and grip.kind != "move")):
        return transform(editor, press, box, grip)
    if part is None:
        return SELECTION.span(editor, press, lambda: ring_on_screen(editor)[:-1:3])
    return drag(editor, press, part)


def drag_corners(editor: Editor, press: Press, corner: int) -> Gesture:
    """Move a corner with its handles, and the other selected ones if it is selected."""
    first = yield from SELECTION.grip(editor, press, corner)
    if first is None:
        return
    corners, knots = find_selected(editor), ring_on_screen(editor)[:-1:3]
    stay = sorted(set(range(CORNERS)) - outline_aids.opposites(corners, editor.session.outline))
    snapping = Snapping(editor, knots[corner], knots[stay])
    move = lambda ring, event: curve_edit.with_knots_moved(ring, corners, snapping.shift(press, event), closed=True)  # noqa: E731
    yield from _follow(editor, "Move corner" if len(corners) == 1 else "Move corners", move, first, by_corners=True)


def drag(editor: Editor, press: Press, part: OutlinePart) -> Gesture:
    """Move a handle, or bend a side at its gripped point."""
    editor.show(selected_corners=frozenset())
    first = yield from drag_from(press.pos)
    if first is None:
        return
    ring, is_side = ring_on_screen(editor), part.kind == "side"
    snapping = Snapping(editor, np.array(press.pos) if is_side else ring[part.number], ring[:-1:3])

    def move(ring: Points, event: Move) -> Points:
        shift = snapping.shift(press, event)
        if is_side:
            return curve_edit.bent(ring, part.t, shift)
        return _handle_moved(ring, part.number, shift, broken=event.mods.alt)

    yield from _follow(editor, "Bend side" if is_side else "Move handle", move, first)


def transform(editor: Editor, press: Press, box: Box, grip: Grip) -> Gesture:
    """Move, scale or turn the selected corners by their box; a click deselects them."""
    numbers = curve_edit.points_of(ring_on_screen(editor), find_selected(editor), closed=True)
    first = yield from SELECTION.grip_box(editor, press)
    if first is None:
        return

    def move(ring: Points, event: Move) -> Points:
        result = ring.copy()
        result[numbers] = apply(box.transform(grip, press.pos, event.pos, held=event.mods.shift), ring[numbers])
        return result

    label = {"move": "Move", "scale": "Scale", "turn": "Turn"}[grip.kind] + " outline"
    yield from _follow(editor, label, move, first, by_corners=True)


def _follow(
    editor: Editor, label: str, move: Callable[[Points, Move], Points], first: Move, *, by_corners: bool = False
) -> Gesture:
    """Keep the outline at `move(its ring at the start, event)`, all on the screen, on both sides alike if so chosen."""
    start, ring, aids = editor.document, ring_on_screen(editor), editor.session.outline
    try:
        with editor.group(label):
            event: Event = first
            while isinstance(event, Move):
                moved = places_from_screen(editor, outline_aids.mirror(ring, move(ring, event), aids)[:-1])
                result = lay_by_corners(start, moved) if by_corners else start.changed(outline=Outline(moved))
                if result is not None:
                    editor.document = result
                event = yield
    finally:
        editor.show(guides=())


def lay_by_corners(document: Document, ring: Points) -> Document | None:
    """Return the document whose outline went to `ring` (12, 2) by its corners; None where they cannot lie so.

    The corners of a perspective stay those of a perspective.
    """
    if not perspective.has_corners(document):
        return document.changed(outline=Outline(ring))
    try:
        return perspective.with_corners(document, ring[::3])
    except InputError:
        return None


def _handle_moved(ring: Points, handle: int, shift: Points, *, broken: bool) -> Points:
    """Return the ring with a handle moved; `broken` lets a smooth corner turn."""
    knot = curve_edit.knot_beside(ring, handle, closed=True)
    before, after = curve_edit.handles_at(ring, knot, closed=True)
    smooth = (
        before is not None and after is not None and curve_edit.is_straight(ring[before], ring[3 * knot], ring[after])
    )
    return curve_edit.with_handle_at(ring, handle, ring[handle] + shift, closed=True, linked=smooth and not broken)


def straighten(editor: Editor, part: OutlinePart) -> None:
    """Lay the handles of a corner, or those of the side, on the straight lines between corners."""
    if perspective.has_corners(editor.document):
        return
    outline = find_outline(editor)
    ring = np.concatenate([outline.ring, outline.ring[:1]])
    if part.kind == "corner":
        ring = curve_edit.make_corner(ring, part.number // 3, closed=True)
    else:
        side = int(part.t) if part.kind == "side" else part.number // 3
        a, b = ring[3 * side], ring[3 * side + 3]
        ring[3 * side + 1 : 3 * side + 3] = [a + (b - a) / 3, a + (b - a) * 2 / 3]
    editor.edit("Straighten outline", editor.document.changed(outline=Outline(ring[:-1])))


def take_key(editor: Editor, key: Key) -> bool:
    """Nudge or deselect the selected corners."""
    corners, step = find_selected(editor), nudge_px(key)
    if not corners:
        return False
    if key.name == "escape":
        editor.show(selected_corners=frozenset())
    elif step is not None:
        label = "Nudge corner" if len(corners) == 1 else "Nudge corners"
        editor.edit(label, move_by(editor, corners, step), joins=True)
    else:
        return False
    return True


def move_by(editor: Editor, corners: frozenset[int], by_px: Points) -> Document:
    """Return the document with corners of the outline moved by canvas pixels (2,), itself where they cannot."""
    outline = find_outline(editor)
    ring = np.concatenate([outline.ring, outline.ring[:1]])
    moved = curve_edit.with_knots_moved(ring, corners, by_px / editor.canvas_px, closed=True)
    moved = outline_aids.mirror(ring, moved, editor.session.outline)
    return lay_by_corners(editor.document, moved[:-1]) or editor.document


def hover(editor: Editor, pos: Position) -> object:
    """Return the part under the pointer."""
    return part_at(editor, pos)


def overlay(editor: Editor) -> Sequence[Shape]:
    """Draw sides, the box, handles with their links, corners, what is under the pointer, and the rubber band."""
    ring, box = ring_on_screen(editor), box_of(editor)
    shapes: list[Shape] = [*(() if box is None else box.shapes()), Bezier(ring, "outline")]
    for number in range(12):
        place = (float(ring[number][0]), float(ring[number][1]))
        if number % 3 == 0:
            chosen = number // 3 in find_selected(editor)
            shapes.append(Square(place, 5.0, "knot-selected" if chosen else "corner", filled=True))
            continue
        corner = 3 * curve_edit.knot_beside(ring, number, closed=True)
        shapes.append(Polyline(ring[[corner, number]], "link"))
        shapes.append(Circle(place, 4.0, "handle", filled=True))
    part = editor.session.hover
    if isinstance(part, OutlinePart):
        at = _on_side(editor, ring, part.t) if part.kind == "side" else ring[part.number]
        if at is not None:
            shapes.append(Circle((float(at[0]), float(at[1])), 8.0, "hover"))
    return [*shapes, *outline_aids.shapes(editor), *band.shapes(editor)]


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
    hint="Drag corners, handles, sides · Shift holds axes · Ctrl never snaps · Alt breaks · double-click straightens",
    press=press,
    cursor="arrow",
    modes=frozenset(("warp",)),
    hover=hover,
    take_key=take_key,
    overlay=overlay,
)
