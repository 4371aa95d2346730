"""The texture tool: moves, turns and scales the new texture on the cloth, which it follows into the folds."""

from dataclasses import replace

import numpy as np

from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.events import Event, Key, Move, Position, Press
from app.model.gestures import Gesture
from app.model.spaces import canvas_from_screen
from app.tools.points.grips import NUDGES, drag_from
from core.arrays import Floats, Points
from core.document.overlay_layers import OverlayLayers
from core.document.overlay_settings import Laying
from core.document.overlay_texture import placement_of, size_of
from core.overlay.composition import finite

LEAST_SIZE, MOST_SIZE = 0.1, 200.0
NUDGE = 0.01
"""Of a copy; ten times as far with Shift."""
REACH_PX = 40
"""So far beside the cloth the nearest cloth is taken."""


def press(editor: Editor, press: Press) -> Gesture | None:
    """Move the texture; with Shift turn it, with Ctrl scale it."""
    layers, cloth = editor.overlay.layers, editor.document.cloth
    if layers is None or cloth.texture is None:
        first = "Find the pattern" if layers is None else "Choose a texture"
        editor.notify(f"{first} first: then the texture is what is moved")
        return None
    return drag(editor, press, layers)


def drag(editor: Editor, press: Press, layers: OverlayLayers) -> Gesture:
    """Follow the pointer."""
    start, before = editor.document, editor.document.cloth.laying
    first = yield from drag_from(press.pos)
    if first is None:
        return
    kind = "Turn texture" if press.mods.shift else "Scale texture" if press.mods.ctrl else "Move texture"
    with editor.group(kind):
        event: Event = first
        while isinstance(event, Move):
            changes = _changes(editor, layers, before, kind, press.pos, event.pos)
            editor.document = start.changed(cloth=start.cloth.with_laying(**changes))
            event = yield


def _changes(
    editor: Editor, layers: OverlayLayers, before: Laying, kind: str, start: Position, now: Position
) -> dict[str, object]:
    """Return what a drag changes of how the texture lies."""
    across, down = now[0] - start[0], now[1] - start[1]
    if kind == "Scale texture":
        return {"size": float(np.clip(size_of(layers, before) * np.exp((across - down) / 200), LEAST_SIZE, MOST_SIZE))}
    if kind == "Turn texture":
        return {"rotate_deg": wrap_deg(before.rotate_deg + 0.4 * across)}
    texture = editor.document.cloth.texture
    matrix = placement_of(layers, texture, before).matrix(layers.basis)
    moved = matrix @ (texels_at(editor, layers, now) - texels_at(editor, layers, start))
    return {"offset": wrap(before, np.array(before.offset) + moved)}


def texels_at(editor: Editor, layers: OverlayLayers, pos: Position) -> Floats:
    """Return the texture coordinates (2,) of the cloth at a screen position, of the undeformed cloth far beside it."""
    x, y = canvas_from_screen(editor.session.view, np.array(pos))
    height, width = layers.coverage.shape
    column, row = int(np.clip(round(x), 0, width - 1)), int(np.clip(round(y), 0, height - 1))
    left, top = max(column - REACH_PX, 0), max(row - REACH_PX, 0)
    part = layers.uv[top : row + REACH_PX + 1, left : column + REACH_PX + 1].astype(np.float64)
    rows, columns = np.nonzero(finite(part))
    if not len(rows):
        return np.asarray(np.linalg.solve(layers.basis, [x, y]), np.float64)
    near = np.argmin(np.hypot(columns + left - x, rows + top - y))
    place: Points = np.array([columns[near] + left, rows[near] + top], float)
    return np.asarray(part[rows[near], columns[near]] + np.linalg.solve(layers.basis, [x, y] - place), np.float64)


def wrap(laying: Laying, offset: Floats) -> tuple[float, float]:
    """Return an offset without whole copies, which look the same, where the texture repeats."""
    period = 2.0 if laying.mirror else 1.0
    u, v = np.mod(offset + period / 2, period) - period / 2 if laying.tile else offset
    return float(u), float(v)


def wrap_deg(angle: float) -> float:
    """Return an angle from -180 to 180 degrees."""
    return float((angle + 180) % 360 - 180)


def take_key(editor: Editor, key: Key) -> bool:
    """Move the texture a little."""
    laying = editor.document.cloth.laying
    if key.name not in NUDGES or key.mods.ctrl or key.mods.alt or editor.document.cloth.texture is None:
        return False
    step = NUDGE * (10 if key.mods.shift else 1) * np.array(NUDGES[key.name])
    cloth = editor.document.cloth.with_laying(offset=wrap(laying, np.array(laying.offset) + step))
    editor.edit("Nudge texture", replace(editor.document, cloth=cloth), joins=True)
    return True


DRAPE = Tool(
    name="drape",
    label="Texture",
    icon="shirt",
    key="t",
    hint="Drag the texture on the cloth · Shift-drag turns · Ctrl-drag scales · arrows nudge",
    press=press,
    modes=frozenset(("overlay",)),
    cursor="move",
    take_key=take_key,
)
