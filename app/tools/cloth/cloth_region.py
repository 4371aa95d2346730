"""Tools that say where the pattern is: a rectangle of cloth, or one texel of the pattern."""

from collections.abc import Sequence

import numpy as np

from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.events import Move, Position, Press
from app.model.gestures import Gesture
from app.model.shapes import Polyline, Shape
from app.model.spaces import canvas_from_screen
from core.arrays import Bytes, Points
from core.document.document import places_from_pixels
from core.document.overlay_settings import Search
from core.rasters.raster import Box, Raster

LEAST_PX = 4.0
"""Smallest rectangle, in screen pixels."""


def rectangle(editor: Editor, press: Press) -> Gesture:
    """Follow the pointer with a rectangle; return None, and leave `Session.band` empty."""
    try:
        while isinstance(event := (yield), Move):
            editor.show(band=(press.pos, event.pos))
        band = editor.session.band
    finally:
        editor.show(band=None)
    if band is not None and min(abs(band[1][0] - band[0][0]), abs(band[1][1] - band[0][1])) >= LEAST_PX:
        _rectangle_done(editor, press, band)


def _rectangle_done(editor: Editor, press: Press, band: tuple[Position, Position]) -> None:
    corners = canvas_from_screen(editor.session.view, np.array(band))
    if editor.session.tool == "texel":
        mark_texel(editor, corners)
    else:
        mark_region(editor, corners, joins=press.mods.shift, cuts=press.mods.alt or press.button == "right")


def mark_texel(editor: Editor, corners: Points) -> None:
    """Find the pattern anew from one texel with opposite corners (2, 2), in pixels."""
    first, second = places_from_pixels(editor.document.size_px, corners).tolist()
    cloth = editor.document.cloth
    search = Search(cloth.region, texel=((first[0], first[1]), (second[0], second[1])), seed=cloth.seed)
    with editor.group("Mark texel"):
        editor.document = editor.document.with_cloth(search=search)
    editor.show(tool="drape", shown="result")


def mark_region(editor: Editor, corners: Points, *, joins: bool, cuts: bool) -> None:
    """Make a rectangle with opposite corners (2, 2), in pixels, the region of cloth; add it, or cut it out."""
    width, height = editor.document.size_px
    low, high = np.rint(corners.min(0) + 0.5).astype(int), np.rint(corners.max(0) + 0.5).astype(int)
    box: Box = max(low[0], 0), max(low[1], 0), min(high[0], width), min(high[1], height)
    if box[0] >= box[2] or box[1] >= box[3]:
        return
    region = editor.document.cloth.region
    base = region if region is not None and (joins or cuts) else Raster.filled(width, height, 255 if cuts else 0)
    with editor.group("Cut from region" if cuts else "Region"):
        editor.document = editor.document.with_cloth(region=fill(base, box, 0 if cuts else 255))


def fill(raster: Raster, box: Box, value: int) -> Raster:
    """Return `raster` with `value` in a box."""

    def edit(tile: Bytes, around: Box) -> Bytes:
        changed = tile.copy()
        left, top = max(box[0] - around[0], 0), max(box[1] - around[1], 0)
        changed[top : max(box[3] - around[1], 0), left : max(box[2] - around[0], 0)] = value
        return changed

    return raster.edited(box, edit)


def overlay(editor: Editor) -> Sequence[Shape]:
    """Draw the rectangle, and the texel that was marked last."""
    band = editor.session.band
    if band is None:
        return ()
    (left, top), (right, bottom) = band
    corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
    return (Polyline(corners, "box", closed=True),)


REGION = Tool(
    name="region",
    label="Region",
    icon="vector-square",
    key="r",
    hint="Drag a rectangle around the patterned cloth · Shift adds · Alt cuts out · the brush (B) paints it",
    press=rectangle,
    modes=frozenset(("overlay",)),
    overlay=overlay,
)

TEXEL = Tool(
    name="texel",
    label="It repeats like this",
    icon="ruler-combined",
    key="i",
    hint="Drag from one corner of a texel to the opposite one: the pattern is found from there",
    press=rectangle,
    modes=frozenset(("overlay",)),
    overlay=overlay,
)
