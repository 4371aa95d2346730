"""The ways of pins that have keys, drawn while the timeline shows: a line, and a square at every key."""

from collections.abc import Iterator

import numpy as np

from app.editor.editor import Editor
from app.model.shapes import Polyline, Shape, Square
from app.tools.points.grips import screen_from_places
from core.document.keys import value_at

STEPS = 48
"""Straight pieces of a way."""


def shapes(editor: Editor) -> Iterator[Shape]:
    """Yield what is drawn, in screen pixels; all of a way lies on the canvas of the frame that is shown."""
    tracks = [pin.keys for pin in editor.document.pins if len(pin.keys) > 1] if editor.session.timeline else []
    for track in tracks:
        frames = np.linspace(track[0].frame, track[-1].frame, STEPS + 1)
        way = screen_from_places(editor, np.array([value_at(track, frame) for frame in frames]))
        yield Polyline(way, "link", dashed=True)
        for x, y in screen_from_places(editor, np.array([key.value for key in track])):
            yield Square((float(x), float(y)), 3.0, "link", filled=True)
