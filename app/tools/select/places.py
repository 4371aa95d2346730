"""From places on the screen to the picture, whatever the canvas shows of it."""

import numpy as np
import scipy

from app.editor.editor import Editor
from app.editor.painting import Side, mesh_on
from app.model.shapes import Polyline, Shape
from app.model.spaces import canvas_from_screen, screen_from_canvas
from core.arrays import Points
from core.mesh import Mesh

GROUP = "select"
STEP_PX = 8.0
"""Straight lines are followed in steps of so many screen pixels where the picture is warped."""


def picture_places(editor: Editor, side: Side, points: Points) -> Points:
    """Return places (n, 2) of the picture at screen positions (n, 2) on a side of the canvas.

    Beside the picture the nearest node is taken; where nothing is warped, places go on outside it.
    """
    mesh = mesh_on(editor, side)
    canvas = canvas_from_screen(editor.session.view, np.reshape(points, (-1, 2)))
    if np.array_equal(mesh.warped, mesh.grid.nodes):
        return canvas
    places = mesh.image_from_canvas(canvas)
    beside = ~np.isfinite(places).all(axis=1)
    if beside.any():
        places[beside] = _nearest_nodes(mesh, canvas[beside])
    return places


def place_on_screen(editor: Editor, side: Side, places: Points) -> Points:
    """Return where places (n, 2) of the picture are on the screen."""
    return screen_from_canvas(editor.session.view, mesh_on(editor, side).canvas_from_image(places))


def densely(outline: Points) -> Points:
    """Return a closed outline (n, 2) with points in steps along its straight sides."""
    ends = np.roll(outline, -1, axis=0)
    counts = np.maximum(np.ceil(np.hypot(*(ends - outline).T) / STEP_PX), 1).astype(int)
    pieces = [
        a + np.arange(count)[:, None] / count * (b - a) for a, b, count in zip(outline, ends, counts, strict=True)
    ]
    return np.concatenate(pieces)


def outline_shapes(editor: Editor) -> list[Shape]:
    """Return the outline that is being drawn, if there is one."""
    outline = editor.session.selection
    return [] if outline is None or len(outline) < 2 else [Polyline(outline, "rubber-band", closed=True)]


def _nearest_nodes(mesh: Mesh, canvas: Points) -> Points:
    """Return where in the picture the nodes nearest to canvas positions (n, 2) are."""
    _, number = scipy.spatial.cKDTree(mesh.warped.reshape(-1, 2)).query(canvas)
    return np.asarray(mesh.grid.nodes.reshape(-1, 2)[number])
