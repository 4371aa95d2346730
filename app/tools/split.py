"""The knife: a line drawn across a feature makes two of it."""

import numpy as np

from app.editor.editor import Editor
from app.editor.painting import side_at
from app.editor.tool import Tool
from app.marking.feature_list import split
from app.model.events import Move, Press
from app.model.gestures import Gesture
from app.model.shapes import Polyline, Shape
from app.tools.points.grips import aim
from app.tools.select.places import picture_places


def cut(editor: Editor, press: Press) -> Gesture:
    """Draw a line and split what it runs across; with Shift it is straight along an axis."""
    path, side = [press.pos], side_at(editor, press.pos)
    try:
        while isinstance(event := (yield), Move):
            path = [press.pos, aim(press.pos, event)] if event.mods.shift else [*path, event.pos]
            editor.show(selection=np.array(path))
    finally:
        editor.show(selection=None)
    if len(path) > 1 and not split(editor, picture_places(editor, side, np.array(path))):
        editor.notify("Nothing is split: draw the line right across a feature, from outside to outside.")


def overlay(editor: Editor) -> list[Shape]:
    """Draw the line."""
    line = editor.session.selection
    return [] if line is None or len(line) < 2 else [Polyline(line, "rubber-band")]


SPLIT = Tool(
    name="split",
    label="Split a feature",
    icon="scissors",
    key="u",
    hint="Draw a line right across a feature: two are made of it · Shift keeps to an axis",
    press=cut,
    modes=frozenset(("warp",)),
    marks=True,
    can_act=lambda editor: not editor.document.mask.is_empty,
    group="select",
    overlay=overlay,
)
