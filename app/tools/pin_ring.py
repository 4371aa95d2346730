"""The ring around the selected pin: dragged around the pin it turns the picture there, to and from it it scales it.

A ring that was never moved is dashed: it shows how the picture is turned by all other handles and holds nothing. Once
moved, it holds.
"""

from collections.abc import Generator, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from app.editor.editor import Editor
from app.model.events import Event, Move, Position, Press
from app.model.shapes import Circle, Polyline, Role, Shape
from app.tools.points.box import STEP_RAD
from app.tools.points.grips import REACH_PX, drag_from
from core.arrays import Points
from core.document.document import Document, Place, pixels_from_places
from core.document.ring import RING_SCALES, Ring
from core.mapping.result import Warped

RING_PX = 34.0
"""Radius of a ring that scales nothing, on the screen."""
LEAST_PX, MOST_PX = 20.0, 120.0
"""Rings of other scales are drawn no smaller and no larger."""
LINE_PX = 4.0
"""The line is gripped from so far away; its knob from as far as any point."""


def with_ring(document: Document, number: int, ring: Ring | None) -> Document:
    """Return the document with another ring on one of its pins."""
    pins = list(document.pins)
    pins[number] = replace(pins[number], ring=ring)
    return document.changed(pins=tuple(pins))


def find_ring(editor: Editor, number: int) -> Ring:
    """Return a pin's ring, or the one that would change nothing: how the picture is turned and scaled there now."""
    pin, answer = editor.document.pins[number], editor.answer
    if pin.ring is not None or answer.result is None:
        return pin.ring or Ring()
    return Ring.of(_turn(answer.result, editor.document.size_px, pin.at))


@lru_cache(maxsize=2)
def _turn(result: Warped, size_px: tuple[int, int], at: Place) -> complex:
    return complex(result.turned_at(pixels_from_places(size_px, np.array([at])))[0])


def is_gripped(editor: Editor, number: int, place: Points, pos: Position) -> bool:
    """Return whether `pos` is on the ring, or its knob, of a pin at `place` (2,) on the screen."""
    ring = find_ring(editor, number)
    off_line = abs(np.hypot(*np.subtract(pos, place)) - _radius(ring))
    return bool(off_line <= LINE_PX) or is_on_knob(editor, number, place, pos)


def is_on_knob(editor: Editor, number: int, place: Points, pos: Position) -> bool:
    """Return whether `pos` is on the knob of the ring of a pin at `place` (2,) on the screen."""
    return bool(np.hypot(*np.subtract(pos, _knob(find_ring(editor, number), place))) <= REACH_PX)


def drag(editor: Editor, press: Press, number: int, place: Points) -> Generator[None, Event, bool]:
    """Turn and scale the picture around a pin at `place`, with Shift by whole steps; return False for a mere click."""
    start, ring = editor.document, find_ring(editor, number)
    first = yield from drag_from(press.pos)
    if first is None:
        return False
    before = complex(*np.subtract(press.pos, place))
    with editor.group("Turn and scale pin"):
        event: Event = first
        while isinstance(event, Move):
            by = complex(*np.subtract(event.pos, place)) / before
            turn_deg, scale = ring.turn_deg + float(np.degrees(np.angle(by))), ring.scale * abs(by)
            if event.mods.shift:
                step = float(np.degrees(STEP_RAD))
                turn_deg, scale = round(turn_deg / step) * step, ring.scale
            turned = Ring(_half_turn(turn_deg), float(np.clip(scale, *RING_SCALES)))
            editor.document = with_ring(start, number, turned)
            event = yield
    return True


def remove(editor: Editor, number: int) -> None:
    """Take a pin's ring off: the picture turns around it as it will."""
    editor.edit("Remove ring", with_ring(editor.document, number, None))


def shapes(editor: Editor, number: int, place: Points) -> Sequence[Shape]:
    """Return the ring of a pin at `place` on the screen and its knob, to draw."""
    ring, holds = find_ring(editor, number), editor.document.pins[number].ring is not None
    role: Role = "box" if holds else "link"
    knob = _knob(ring, place)
    line = Circle((float(place[0]), float(place[1])), _radius(ring), role, dashed=not holds)
    spoke = Polyline(np.stack([place, knob]), role, dashed=not holds)
    return [line, spoke, Circle(knob, 4.5, role, filled=True)]


def _radius(ring: Ring) -> float:
    return float(np.clip(RING_PX * ring.scale, LEAST_PX, MOST_PX))


def _knob(ring: Ring, place: Points) -> Position:
    """Return where the knob is: above the pin where nothing is turned."""
    end = -1j * np.exp(1j * np.radians(ring.turn_deg)) * _radius(ring)
    return float(place[0] + end.real), float(place[1] + end.imag)


def _half_turn(degrees: float) -> float:
    """Return the same turn, from -180 to 180 degrees."""
    return (degrees + 180) % 360 - 180
