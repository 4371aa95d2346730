"""Long edges of the picture that Retexture keeps by itself: drawn thin, and clicked away with Alt."""

import numpy as np

from app.editor.editor import Editor
from app.model.events import Position
from app.model.shapes import Polyline, Shape
from app.model.spaces import screen_from_canvas
from core.arrays import Points
from core.document.document import places_from_pixels

REACH_PX = 7.0
"""A click hits an edge so far around it, on the screen."""
STEP_PX = 4.0
"""Edges are drawn through places so far apart in the picture."""


def edge_shapes(editor: Editor) -> list[Shape]:
    """Return the edges that the present result keeps, where the picture that is looked at shows them."""
    return [Polyline(line, "edge") for line, _ in _lines(editor)]


def leave_edge_out(editor: Editor, pos: Position) -> bool:
    """Leave the edge under the pointer out of the next results, as one undo entry; return whether there was one."""
    found = [(np.linalg.norm(line - pos, axis=1), places) for line, places in _lines(editor)]
    near = [(float(far.min()), tuple(map(float, places[far.argmin()]))) for far, places in found]
    if not near or min(near)[0] > REACH_PX:
        return False
    left_out = editor.document.retexture.left_out
    editor.edit("Leave edge out", editor.document.with_retexture(left_out=(*left_out, min(near)[1])))
    return True


def _lines(editor: Editor) -> list[tuple[Points, Points]]:
    """Return where each edge is on the screen (n, 2), and its places in the picture (n, 2), normalised."""
    stage = editor.regrowth.stage
    if editor.session.mode != "retexture" or stage is None or not editor.document.retexture.long_edges:
        return []
    is_original = editor.session.look == "original"
    mesh = editor.regrowth.flat if is_original else editor.answer.mesh
    found = []
    for edge in stage.found.edges:
        points = edge.at(edge.parameters(step=STEP_PX))
        canvas = mesh.canvas_from_image(points)
        shown = np.isfinite(canvas).all(axis=1)
        if shown.sum() > 1:
            places = places_from_pixels(editor.document.size_px, points[shown])
            found.append((screen_from_canvas(editor.session.view, canvas[shown]), places))
    return found
