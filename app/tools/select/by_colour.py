"""Selections by colour: the magic wand, and a range of colours."""

import numpy as np

from app.editor.editor import Editor
from app.editor.painting import side_at
from app.marking.applying import choose_combining, select_later
from app.model.events import Move, Press
from app.model.gestures import Gesture
from app.tools.select.outlined import WAYS, make_select_tool
from app.tools.select.places import picture_places
from core.arrays import Bytes, Ints
from core.imaging.proxy import proxy
from core.progress import in_one_step
from core.selection.colours import select_alike, select_range

RANGE_SHARE = 100 / 255
"""Tolerances are of 255 levels; from black to white it is 100 in CIELAB."""
MOST_SAMPLES = 24
"""So many of the colours under a drag are looked for."""


def wand(editor: Editor, press: Press) -> Gesture | None:
    """Select what is coloured like the pixel that is clicked."""
    image, settings = editor.document.image, editor.session.selecting
    spot = _pixels(editor, press, [press.pos])
    if not len(spot):
        return None
    at = int(spot[0, 0]), int(spot[0, 1])

    def find() -> Bytes:
        return select_alike(proxy(image, 1.0), at, settings.tolerance, contiguous=settings.contiguous)

    select_later(editor, "by wand", choose_combining(editor, press.mods), lambda: in_one_step("selecting", find))
    return None


def colour_range(editor: Editor, press: Press) -> Gesture:
    """Drag over colours; what has one of them, wherever it is, is selected."""
    image, settings, path = editor.document.image, editor.session.selecting, [press.pos]
    how = choose_combining(editor, press.mods)
    while isinstance(event := (yield), Move):
        path.append(event.pos)
    pixels = _pixels(editor, press, path)
    if not len(pixels):
        return

    def find() -> Bytes:
        picture = proxy(image, 1.0)
        samples = np.unique(picture[pixels[:, 1], pixels[:, 0]], axis=0)
        chosen = samples[np.linspace(0, len(samples) - 1, min(len(samples), MOST_SAMPLES)).astype(int)]
        return select_range(picture, chosen, settings.tolerance * RANGE_SHARE)

    select_later(editor, "range of colours", how, lambda: in_one_step("selecting", find))


def _pixels(editor: Editor, press: Press, path: list[tuple[float, float]]) -> Ints:
    """Return the pixels (n, 2) of the picture under screen positions, those that there are."""
    places = np.rint(picture_places(editor, side_at(editor, press.pos), np.array(path))).astype(np.int64)
    inside = ((places >= 0) & (places < editor.document.size_px)).all(axis=1)
    return places[inside]


WAND = make_select_tool(
    "wand", "Magic wand", "wand-sparkles", "w", f"Click a colour: what is like it is selected · {WAYS}", wand
)
COLOUR_RANGE = make_select_tool(
    "colour-range",
    "Colour range",
    "eye-dropper",
    "v",
    f"Click or drag over colours: they are selected wherever they are · {WAYS}",
    colour_range,
)
