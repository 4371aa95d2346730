"""The mask brush: paints what must keep its shape, where the artist sees it on the deformed picture.

In Retexture mode it paints where the result may differ, or, on the picture as it is, where texture is taken from; in
Overlay mode where the cloth is.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from app.editor.editor import Editor
from app.editor.painting import LAYERS, Side, choose_raster, layer, mesh_on, show_painted, side_at, with_layer
from app.editor.tool import Tool
from app.marking.applying import number_for, with_grown
from app.model.events import Key, Move, Position, Press
from app.model.gestures import Gesture
from app.model.session import Brush
from app.model.shapes import Circle, Shape
from app.model.spaces import canvas_from_screen
from core.arrays import Points
from core.document.document import Document
from core.document.retexture import moves
from core.masks.brush import Stroke, Tip

LEAST_PX, MOST_PX = 1.0, 4000.0
"""Diameters that the brush may have, in canvas pixels."""
SIZE_STEP = 1.15
HARDNESS_STEP = 0.1
HARDNESS_DRAG_PX = 200.0
"""An Alt-drag of so many pixels down takes the hardness from 1 to 0."""


def resize(brush: Brush, diameter_px: float) -> Brush:
    """Return the brush with another diameter, within bounds."""
    return replace(brush, diameter_px=float(np.clip(diameter_px, LEAST_PX, MOST_PX)))


def harden(brush: Brush, hardness: float) -> Brush:
    """Return the brush with another hardness, within bounds."""
    return replace(brush, hardness=float(np.clip(hardness, 0.0, 1.0)))


def grow(brush: Brush, steps: int) -> Brush:
    """Return the brush some steps larger, or smaller where `steps` is negative; each step is at least a pixel."""
    for _ in range(abs(steps)):
        bolder, finer = brush.diameter_px * SIZE_STEP, brush.diameter_px / SIZE_STEP
        size = max(bolder, brush.diameter_px + 1) if steps > 0 else min(finer, brush.diameter_px - 1)
        brush = resize(brush, round(size))
    return brush


def press(editor: Editor, press: Press) -> Gesture | None:
    """Paint, or with Alt set the brush; where texture is taken from is painted on the picture as it is."""
    if press.mods.alt or press.button == "right":
        return set_brush(editor, press)
    if choose_raster(editor) == "source_mask" and editor.session.look != "original" and moves(editor.document):
        editor.show(look="original")
        editor.notify("Where texture is taken from is painted on the original picture.")
        return None
    return paint(editor, press)


def set_brush(editor: Editor, press: Press) -> Gesture:
    """Change the size by dragging across and the hardness by dragging down."""
    start, zoom = editor.session.brush, editor.session.view.zoom
    try:
        while isinstance(event := (yield), Move):
            across, down = event.pos[0] - press.pos[0], event.pos[1] - press.pos[1]
            brush = resize(start, start.diameter_px + 2 * across / zoom)
            editor.show(brush=harden(brush, start.hardness - down / HARDNESS_DRAG_PX), hover=press.pos)
    except GeneratorExit:
        editor.show(brush=start)
        raise
    finally:
        editor.show(hover=None)


def paint(editor: Editor, press: Press) -> Gesture:
    """Draw a stroke; with Shift it begins with a straight line from where the last one ended."""
    show_painted(editor)
    brush = editor.session.brush
    tip = Tip(brush.diameter_px / 2, brush.hardness)
    here = _canvas(editor, press.pos)
    last = editor.session.last_dab
    name = choose_raster(editor)
    side, number = side_at(editor, press.pos), None if brush.erase else number_for(editor)
    start = editor.document
    with editor.group(f"{'Erase' if brush.erase else 'Paint'} {LAYERS[name]}"):
        stroke = Stroke(layer(editor.document, name), erase=brush.erase)
        _extend(editor, stroke, np.array(last) if press.mods.shift and last is not None else here, here, tip, side)
        _number(editor, stroke, start, number)
        while isinstance(event := (yield), Move):
            before, here = here, _canvas(editor, event.pos)
            _extend(editor, stroke, before, here, tip, side)
            _number(editor, stroke, start, number)
        if number is None and not brush.erase:
            editor.document = with_grown(start, name, layer(editor.document, name), touching=True)
    editor.show(last_dab=(float(here[0]), float(here[1])))


def _extend(editor: Editor, stroke: Stroke, a: Points, b: Points, tip: Tip, side: Side) -> None:
    """Draw on over the picture as it is on the screen, on one side of a split view."""
    stroke.extend(mesh_on(editor, side), a, b, tip)
    editor.document = with_layer(editor.document, choose_raster(editor), stroke.mask)


def _number(editor: Editor, stroke: Stroke, start: Document, number: int | None) -> None:
    """Give what the stroke covers its number, where it has one; `start` is the document before it."""
    if number is not None:
        editor.document = editor.document.changed(numbers=stroke.number_pixels(start.numbers, number))


def _canvas(editor: Editor, pos: Position) -> Points:
    return canvas_from_screen(editor.session.view, np.array(pos))


def take_key(editor: Editor, key: Key) -> bool:
    """Change the brush by the keys that painters know."""
    brush = editor.session.brush
    if key.mods.ctrl or key.mods.alt:
        return False
    match key.name, key.mods.shift:
        case ("[" | "]" as side, False):
            editor.show(brush=grow(brush, 1 if side == "]" else -1))
        case ("[" | "]" as side, True):
            editor.show(brush=harden(brush, brush.hardness + (HARDNESS_STEP if side == "]" else -HARDNESS_STEP)))
        case ("x", False):
            editor.show(brush=replace(brush, erase=not brush.erase))
        case _:
            return False
    return True


def overlay(editor: Editor) -> Sequence[Shape]:
    """Draw the brush's edge and core in their true size; while it is being set, where that began."""
    held = editor.session.hover
    pos = held if isinstance(held, tuple) else editor.session.pointer
    if pos is None:
        return ()
    brush, zoom = editor.session.brush, editor.session.view.zoom
    tip = Tip(brush.diameter_px / 2, brush.hardness)
    edge = Circle(pos, tip.reach_px * zoom, "brush-erase" if brush.erase else "brush")
    return (edge, Circle(pos, tip.core_px * zoom, "brush-core")) if tip.core_px > 0 else (edge,)


def say_moment(editor: Editor) -> str:
    """Return what painting does where that is neither a mask nor a region."""
    if choose_raster(editor) != "regrow":
        return ""
    return "Paint what is regrown · X paints what is not · [ ] size · Shift+[ ] hardness · Shift-click a line"


BRUSH = Tool(
    name="brush",
    label="Mask brush",
    icon="paintbrush",
    key="b",
    hint="Paint a mask · X erases · [ ] size · Shift+[ ] hardness · Alt-drag both · Shift-click a line",
    press=press,
    moment=say_moment,
    cursor="none",
    take_key=take_key,
    marks=True,
    overlay=overlay,
)
