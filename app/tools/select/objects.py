"""Objects that stand out from their ground: in a box, under rough paint, or along their edge."""

import cv2
import numpy as np

from app.editor.editor import Editor
from app.editor.painting import Side, side_at
from app.marking.applying import choose_combining, select, select_later
from app.model.events import Event, Key, Move, Press
from app.model.gestures import Gesture
from app.model.shapes import Polyline, Shape
from app.tools.points.grips import drag_from
from app.tools.select.outlined import WAYS, closes, make_select_tool
from app.tools.select.places import picture_places, place_on_screen
from core.arrays import Bytes, Points
from core.curves.edge_tracing import Scissors
from core.masks.object_masks import object_under
from core.progress import Job
from core.selection.combining import Combining
from core.selection.objects import object_in_box
from core.selection.shapes import fill_polygon, rectangle_outline
from core.selection.sources import has_transparency, opaque_under


def pick_object(editor: Editor, press: Press) -> Gesture:
    """Drag a box around an object, or, if so chosen, paint over it roughly."""
    by_stroke, side = editor.session.selecting.by_stroke, side_at(editor, press.pos)
    how, path = choose_combining(editor, press.mods), [press.pos]
    event: Event | None = yield from drag_from(press.pos)
    try:
        while isinstance(event, Move):
            path = [*path, event.pos] if by_stroke else [press.pos, event.pos]
            corners = np.array([path[0], path[-1]])
            editor.show(selection=np.array(path) if by_stroke else rectangle_outline(*corners, along=1))
            event = yield
    finally:
        editor.show(selection=None)
    if len(path) > 1:
        find = _under_stroke if by_stroke else _in_box
        find(editor, picture_places(editor, side, np.array(path)), how)


def _in_box(editor: Editor, corners: Points, how: Combining) -> None:
    """Look for the object in the box with opposite `corners` (2, 2), in pixels of the picture."""
    image, (low, high) = editor.document.image, (corners.min(axis=0), corners.max(axis=0))

    select_later(editor, "object", how, lambda: object_in_box(image, low, high))


def _under_stroke(editor: Editor, path: Points, how: Combining) -> None:
    """Look for the object under a stroke of the brush along `path` (n, 2), in pixels of the picture."""
    image, width_px = editor.document.image, max(round(editor.session.brush.diameter_px), 3)
    rough = np.zeros((image.height_px, image.width_px), np.uint8)
    cv2.polylines(rough, [np.rint(path).astype(np.int32)], isClosed=False, color=(255,), thickness=width_px)

    def find() -> Job[Bytes]:
        if has_transparency(image):
            return opaque_under(image, rough)
        return (yield from object_under(image, rough))

    select_later(editor, "object", how, find)


def cling(editor: Editor, press: Press) -> Gesture:
    """Follow an edge of the picture from click to click until Enter, a double click, or a click on the first one."""
    how, side = choose_combining(editor, press.mods), side_at(editor, press.pos)
    scissors = Scissors(editor.document.image, scale=editor.session.view.zoom)
    anchors = [scissors.begin(_place(editor, side, press.pos))]
    pieces: list[Points] = []
    corners = [press.pos]
    try:
        while not closes(event := (yield), corners):
            further: list[Points] = []
            if isinstance(event, Press):
                pieces.append(scissors.path_to(_place(editor, side, event.pos)))
                anchors.append(scissors.begin(pieces[-1][-1]))
                corners.append(event.pos)
            elif isinstance(event, Key):
                anchors, pieces, corners = anchors[:-1], pieces[:-1], corners[:-1]
                if not anchors:
                    return
                scissors.begin(anchors[-1])
            elif isinstance(event, Move):
                further = [scissors.path_to(_place(editor, side, event.pos))]
            line = np.concatenate([anchors[0][None], *pieces, *further])
            editor.show(selection=place_on_screen(editor, side, line))
        closing = scissors.path_to(anchors[0]) if pieces else anchors[0][None]
    finally:
        editor.show(selection=None)
    if pieces:
        outline = np.concatenate([anchors[0][None], *pieces, closing])
        select(editor, "along edges", fill_polygon(editor.document.size_px, outline), how)


def _place(editor: Editor, side: Side, pos: tuple[float, float]) -> Points:
    """Return the place (2,) of the picture at a screen position."""
    return np.asarray(picture_places(editor, side, np.array([pos]))[0])


def _open_line(editor: Editor) -> list[Shape]:
    """Draw the line so far; it is closed along edges, too."""
    line = editor.session.selection
    return [] if line is None or len(line) < 2 else [Polyline(line, "rubber-band")]


OBJECT = make_select_tool(
    "object",
    "Select an object",
    "object-ungroup",
    "q",
    f"Drag a box around an object, or paint over it: its outline is found · {WAYS}",
    pick_object,
)
CLING = make_select_tool(
    "cling",
    "Lasso along edges",
    "magnet",
    "a",
    f"Click along an edge: the outline clings to it · Enter or the first click closes · {WAYS}",
    cling,
    overlay=_open_line,
)
