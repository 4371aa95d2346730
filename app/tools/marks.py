"""All that is drawn over the picture: the tool's own shapes, and below them the handles that other tools set."""

import numpy as np

from app.editor.editor import Editor
from app.marking.feature_list import feature_list
from app.model.shapes import Bezier, Circle, Polyline, Role, Shape
from app.model.spaces import screen_from_canvas
from app.tools.cloth.lattice import lattice_shapes
from app.tools.curves.curves import FEATURE_CURVES, WARP_CURVES
from app.tools.curves.kept_edges import edge_shapes
from app.tools.outline import ring_on_screen
from app.tools.pins import targets_on_screen
from app.tools.select.places import place_on_screen

PIN_PX = 3.0
CURVE_TOOLS = ("feature-curves", "trace")
HANDLE_TOOLS = ("pins", "curves", *CURVE_TOOLS)


def marks(editor: Editor) -> list[Shape]:
    """Return the shapes to draw now, in screen pixels, the lowest first.

    The tool's shapes stay while another tool is held for a moment.
    """
    session = editor.session
    tool = editor.tools[session.tool]
    by_mode = {"warp": _handles, "retexture": _feature_curves, "overlay": _lattice}
    others = by_mode[session.mode](editor)
    in_hand = () if _is_hidden(editor) else tool.overlay(editor)
    return [*_patches(editor), *_lit(editor), *others, *in_hand]


def _lit(editor: Editor) -> list[Shape]:
    """Return the outline of the feature that the pointer is on in the list, and of those chosen there."""
    session = editor.session
    if session.mode != "warp" or editor.is_busy:
        return []
    document, grid, found = editor.document, editor.map.grid, feature_list(editor)
    there = {row.id for row in found.rows(document, grid)}
    roles: list[tuple[int | None, Role]] = [(number, "box") for number in session.features if number != session.lit]
    shapes: list[Shape] = []
    for number, role in [*roles, (session.lit, "hover")]:
        if number in there:
            lines = found.outline(document, grid, number)
            shapes += [Polyline(place_on_screen(editor, "result", line), role, closed=True) for line in lines]
    return shapes


def _is_hidden(editor: Editor) -> bool:
    """Return whether the handles that the tool in hand edits are switched off; while it acts, they are shown."""
    session = editor.session
    return session.tool in HANDLE_TOOLS and not session.overlays.handles and not editor.is_busy


def _handles(editor: Editor) -> list[Shape]:
    """Return outline, curves and pins in their quiet form, as far as they are switched on.

    Of an outline that was not set there is only the nearest four sides; where the picture ends, its own edge shows.
    """
    session, document = editor.session, editor.document
    shapes: list[Shape] = []
    if editor.unwarped.is_shown:
        return shapes  # all of them lie on the result
    if session.overlays.outline and session.tool != "outline" and document.outline is not None:
        shapes.append(Bezier(ring_on_screen(editor), "outline"))
    if session.overlays.handles and session.tool != "curves":
        shapes.extend(Bezier(WARP_CURVES.on_screen(editor, pair, "target"), "target") for pair in document.curves)
    if session.overlays.handles and session.tool != "pins":
        places = np.reshape(targets_on_screen(editor), (-1, 2))
        shapes.extend(Circle((float(x), float(y)), PIN_PX, "pin-rest", filled=True) for x, y in places)
    return shapes


def _feature_curves(editor: Editor) -> list[Shape]:
    """Return where the feature curves of Retexture mode go, in their quiet form."""
    session = editor.session
    if session.mode != "retexture" or not session.overlays.handles:
        return []
    shapes: list[Shape] = [*edge_shapes(editor), *_followers(editor)]
    if session.tool in CURVE_TOOLS:
        return shapes
    for pair in editor.document.feature_curves:
        if pair.passive:
            shapes.append(Bezier(FEATURE_CURVES.on_screen(editor, pair, "source"), "passive"))
        else:
            shapes.append(Bezier(FEATURE_CURVES.on_screen(editor, pair, "target"), "target"))
    return shapes


def _followers(editor: Editor) -> list[Shape]:
    """Return where the deformation has taken passive curves, on the pictures that show it."""
    stage = editor.regrowth.stage
    if stage is None or editor.session.look == "original":
        return []
    view = editor.session.view
    return [Bezier(screen_from_canvas(view, line.points), "passive", dashed=True) for line in stage.followers]


def _lattice(editor: Editor) -> list[Shape]:
    """Return the lattice of Overlay mode while the pattern is being found, and until a texture covers what was found.

    It is also drawn wherever the photo is looked at.
    """
    session = editor.session
    if session.tool == "lattice" or not session.overlays.handles:
        return []
    is_bare = session.shown == "result" and editor.document.cloth.texture is None
    return lattice_shapes(editor) if editor.overlay.is_running or session.shown == "photo" or is_bare else []


def _patches(editor: Editor) -> list[Shape]:
    """Return outlines of patches and the lines of their coordinates, as far as they are switched on."""
    session, stage = editor.session, editor.regrowth.stage
    overlays, shapes = session.overlays, list[Shape]()
    if session.mode != "retexture" or session.look == "original" or stage is None:
        return shapes
    if not (overlays.patches or overlays.spines):
        return shapes
    for grid in screen_from_canvas(session.view, stage.grids):
        if overlays.spines:
            shapes += [Polyline(grid[grid.shape[0] // 2], "spine"), Polyline(grid[:, grid.shape[1] // 2], "spine")]
        if overlays.patches:
            edge = np.concatenate([grid[0], grid[1:, -1], grid[-1, -2::-1], grid[-2:0:-1, 0]])
            shapes.append(Polyline(edge, "patch", closed=True))
    return shapes
