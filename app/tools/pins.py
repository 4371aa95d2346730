"""Pins: points of the picture that are held or moved."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.events import Event, Key, Move, Position, Press
from app.model.gestures import Gesture
from app.model.shapes import Circle, Polyline, Role, Shape
from app.model.spaces import canvas_from_screen, screen_from_canvas
from app.tools import pin_path, pin_ring
from app.tools.points import band
from app.tools.points.box import Box, Grip, apply
from app.tools.points.grips import (
    aim,
    drag_from,
    nearest,
    nudge_px,
    places_from_screen,
    screen_from_places,
)
from app.tools.points.selection import Selection
from core.arrays import Points
from core.document.document import Document, Pin, Place, pixels_from_places, places_from_pixels
from core.mapping.tolerances import SEEN_PX

PIN_PX = 5.0


def targets_on_screen(editor: Editor) -> Points:
    """Return where the pins are (n, 2), in screen pixels."""
    return screen_from_places(editor, np.array([pin.to for pin in editor.document.pins]))


def find_selected(editor: Editor) -> frozenset[int]:
    """Return the numbers of the selected pins that there are."""
    return frozenset(number for number in editor.session.selected if number < len(editor.document.pins))


SELECTION = Selection("selected", find_selected)


def box_of(editor: Editor) -> Box | None:
    """Return the box around the selected pins if they are several."""
    return Box.around(targets_on_screen(editor)[sorted(find_selected(editor))])


def find_ringed_pin(editor: Editor) -> int | None:
    """Return the number of the pin around which a ring is drawn: the one that is selected alone."""
    numbers = find_selected(editor)
    return next(iter(numbers)) if len(numbers) == 1 else None


def with_targets(document: Document, numbers: Iterable[int], places: Points) -> Document:
    """Return the document with some pins moved to `places` (n, 2)."""
    pins = list(document.pins)
    for number, (x, y) in zip(numbers, places, strict=True):
        pins[number] = replace(pins[number], to=(float(x), float(y)))
    return document.changed(pins=tuple(pins))


def with_stiffness(document: Document, numbers: Iterable[int], stiff: float) -> Document:
    """Return the document with some pins stiff so far around, as a share of the picture's diagonal."""
    pins = list(document.pins)
    for number in numbers:
        pins[number] = replace(pins[number], stiff=stiff)
    return document.changed(pins=tuple(pins))


def press(editor: Editor, press: Press) -> Gesture | None:
    """Remove, move, transform, select or add, by what is under the pointer and which key is held."""
    places = targets_on_screen(editor)
    pin, ringed = nearest(places, press.pos), find_ringed_pin(editor)
    on_ring = ringed is not None and pin_ring.is_gripped(editor, ringed, places[ringed], press.pos)
    if press.mods.alt or press.button == "right":
        if pin is not None:
            remove(editor, {pin})
        elif ringed is not None and on_ring:
            pin_ring.remove(editor, ringed)
        return None
    if pin is not None:
        return drag(editor, press, pin)
    if ringed is not None and on_ring:
        return turn_or_add(editor, press, ringed, places[ringed])
    box = box_of(editor)
    grip = box.grip(press.pos) if box is not None else None
    if box is not None and grip is not None:
        return transform(editor, press, box, grip)
    at = _picture_place(editor, press.pos)
    if press.mods.shift or at is None:
        return SELECTION.span(editor, press, lambda: targets_on_screen(editor))
    return add(editor, press, at)


def turn_or_add(editor: Editor, press: Press, ringed: int, place: Points) -> Gesture:
    """Turn and scale the picture around a pin by its ring; a mere click on its line, not its knob, adds a pin there."""
    on_knob = pin_ring.is_on_knob(editor, ringed, place, press.pos)
    turned = yield from pin_ring.drag(editor, press, ringed, place)
    at = _picture_place(editor, press.pos)
    if not (turned or on_knob) and at is not None:
        with editor.group("Add pin"):
            _put(editor, press, at)


def _put(editor: Editor, press: Press, at: Place) -> int:
    """Put a pin on the picture, select it and return its number."""
    to = places_from_screen(editor, np.array(press.pos))[0]
    pin = Pin(at, (float(to[0]), float(to[1])))
    editor.document = editor.document.changed(pins=(*editor.document.pins, pin))
    number = len(editor.document.pins) - 1
    editor.show(selected=frozenset({number}))
    return number


def add(editor: Editor, press: Press, at: Place) -> Gesture:
    """Put a pin on the picture and, while the button is held, move it."""
    with editor.group("Add pin"):
        number = _put(editor, press, at)
        first = yield from drag_from(press.pos)
        if first is not None:
            yield from _follow(editor, press, [number], first)


def drag(editor: Editor, press: Press, pin: int) -> Gesture:
    """Move a pin, and the other selected ones if it is selected."""
    first = yield from SELECTION.grip(editor, press, pin)
    if first is None:
        return
    numbers = sorted(find_selected(editor))
    with editor.group("Move pin" if len(numbers) == 1 else "Move pins"):
        yield from _follow(editor, press, numbers, first)


def _follow(editor: Editor, press: Press, numbers: Sequence[int], first: Move) -> Gesture:
    """Move pins with the pointer; with Shift along an axis."""
    start, places = editor.document, targets_on_screen(editor)[list(numbers)]
    event: Event = first
    while isinstance(event, Move):
        shift = np.subtract(aim(press.pos, event), press.pos)
        editor.document = with_targets(start, numbers, places_from_screen(editor, places + shift))
        event = yield


def transform(editor: Editor, press: Press, box: Box, grip: Grip) -> Gesture:
    """Move, scale or turn the selected pins by their box."""
    numbers = sorted(find_selected(editor))
    start, places = editor.document, targets_on_screen(editor)[numbers]
    first = yield from SELECTION.grip_box(editor, press)
    if first is None:
        return
    with editor.group({"move": "Move pins", "scale": "Scale pins", "turn": "Turn pins"}[grip.kind]):
        event: Event = first
        while isinstance(event, Move):
            matrix = box.transform(grip, press.pos, event.pos, held=event.mods.shift)
            editor.document = with_targets(start, numbers, places_from_screen(editor, apply(matrix, places)))
            event = yield


def remove(editor: Editor, numbers: Iterable[int]) -> None:
    """Take pins out."""
    gone = frozenset(numbers)
    pins = tuple(pin for number, pin in enumerate(editor.document.pins) if number not in gone)
    editor.edit("Remove pin" if len(gone) == 1 else "Remove pins", editor.document.changed(pins=pins))
    editor.show(selected=frozenset(), hover=None)


def take_key(editor: Editor, key: Key) -> bool:
    """Remove, nudge or deselect the selected pins."""
    numbers = sorted(find_selected(editor))
    step = nudge_px(key)
    if not numbers or key.mods.ctrl or key.mods.alt:
        return False
    if key.name in ("delete", "backspace"):
        remove(editor, numbers)
    elif key.name == "escape":
        editor.show(selected=frozenset())
    elif step is not None:
        places = np.array([editor.document.pins[number].to for number in numbers])
        editor.edit("Nudge pins", with_targets(editor.document, numbers, places + step / editor.canvas_px), joins=True)
    else:
        return False
    return True


def hover(editor: Editor, pos: Position) -> object:
    """Return the number of the pin under the pointer."""
    return nearest(targets_on_screen(editor), pos)


def overlay(editor: Editor) -> Sequence[Shape]:
    """Draw the box, the ring of the one selected pin, what is stiff around pins, the pins and the rubber band."""
    chosen, box = find_selected(editor), box_of(editor)
    shapes: list[Shape] = [] if box is None else list(box.shapes())
    targets = targets_on_screen(editor)
    shapes.extend(_misses(editor, targets))
    shapes.extend(pin_path.shapes(editor))
    ringed = find_ringed_pin(editor)
    if ringed is not None:
        shapes.extend(pin_ring.shapes(editor, ringed, targets[ringed]))
    shapes.extend(_reach_of_stiff(editor, pin) for pin in editor.document.pins if pin.stiff > 0)
    for number, (x, y) in enumerate(targets):
        if number == editor.session.hover:
            shapes.append(Circle((float(x), float(y)), PIN_PX + 3, "hover"))
        role: Role = "pin-selected" if number in chosen else "pin"
        shapes.append(Circle((float(x), float(y)), PIN_PX, role, filled=True))
    return [*shapes, *band.shapes(editor)]


def measure_miss_px(editor: Editor, number: int) -> float:
    """Return how far a pin, or its ring, is from where it was dragged, in pixels of the canvas.

    0 where it holds, and as long as the final answer is worked out, which may still meet it.
    """
    reports = editor.map.pins if editor.map.settled else []
    error = reports[number].worst_px if len(reports) == len(editor.document.pins) else 0.0
    return error if error > SEEN_PX else 0.0


def _reach_of_stiff(editor: Editor, pin: Pin) -> Polyline:
    """Return a line around what is stiff at a pin, where the picture has it now."""
    size, around = editor.document.size_px, np.exp(2j * np.pi * np.arange(64) / 64)
    radius = pin.stiff * float(np.hypot(*size))
    ring = pixels_from_places(size, np.array(pin.at)) + radius * np.stack([around.real, around.imag], axis=-1)
    ring = np.clip(ring, -0.5, np.subtract(size, 0.5))
    seen = editor.answer.mesh.canvas_from_image(ring)
    return Polyline(screen_from_canvas(editor.session.view, seen), "pin-rest", closed=True)


def _misses(editor: Editor, targets: Points) -> Iterator[Shape]:
    """Yield a line from every pin that could not be met, in screen pixels, to where its point is."""
    for number, target in enumerate(targets):
        if measure_miss_px(editor, number):
            reached = np.array([editor.answer.pins[number].reached])
            there = screen_from_canvas(editor.session.view, reached)[0]
            yield Polyline(np.stack([target, there]), "faulty", dashed=True)
            yield Circle((float(there[0]), float(there[1])), PIN_PX - 2, "faulty")


def _picture_place(editor: Editor, pos: Position) -> Place | None:
    """Return the place of the picture that is seen at `pos`; None beside the picture."""
    canvas = canvas_from_screen(editor.session.view, np.array([pos]))
    place = places_from_pixels(editor.document.size_px, editor.answer.mesh.image_from_canvas(canvas))[0]
    return None if np.isnan(place).any() else (float(place[0]), float(place[1]))


PINS = Tool(
    name="pins",
    label="Pins",
    icon="thumbtack",
    key="p",
    hint="Click to add, drag to move, its ring to turn and scale · Shift: axis, steps, several · Alt-click removes",
    press=press,
    modes=frozenset(("warp",)),
    hover=hover,
    take_key=take_key,
    overlay=overlay,
)
