"""The lattice tool: moves, adds and removes the vertices that the pattern repeats at; the rest is found anew."""

from collections.abc import Sequence
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.events import Event, Key, Move, Position, Press
from app.model.gestures import Gesture
from app.model.shapes import Circle, Polyline, Shape
from app.model.spaces import canvas_from_screen, screen_from_canvas
from app.tools.cloth.lattice_web import Web, web_of
from app.tools.points.grips import drag_from, nearest
from core.arrays import Floats, Points
from core.document.document import pixels_from_places, places_from_pixels
from core.document.overlay import OverlayLayers, vertices_of
from core.document.overlay_settings import LatticeVertices, Search

VERTEX_PX, LEAST_VERTEX_PX = 3.5, 1.6
"""Radius of a vertex; smaller where vertices are close together."""
FITS = 0.4
"""A new vertex lies so near where the lattice goes on, in its steps."""
WEAK = 0.5
"""Confidence below which a quad is marked."""


_FOUND: "WeakKeyDictionary[OverlayLayers, LatticeVertices]" = WeakKeyDictionary()
"""Layers and their lattice, which is drawn in every frame."""


def vertices(editor: Editor) -> LatticeVertices | None:
    """Return the present lattice: the artist's while the rest is being found, else the one that was found."""
    work, search = editor.overlay, editor.document.cloth.search
    if search is not None and search.lattice is not None and not work.is_final:
        return search.lattice
    layers = work.layers
    if layers is None or search is None:
        return None
    if layers not in _FOUND:
        _FOUND[layers] = vertices_of(editor.document, layers)
    return _FOUND[layers]


def on_screen(editor: Editor, lattice: LatticeVertices) -> Points:
    """Return where the vertices (n, 2) are, in screen pixels."""
    return screen_from_canvas(editor.session.view, pixels_from_places(editor.document.size_px, lattice.places))


def press(editor: Editor, press: Press) -> Gesture | None:
    """Remove, move or add a vertex."""
    lattice = vertices(editor)
    if lattice is None or not len(lattice.keys):
        return None
    vertex = nearest(on_screen(editor, lattice), press.pos)
    if press.mods.alt or press.button == "right":
        if vertex is not None:
            remove(editor, lattice, vertex)
        return None
    return move(editor, lattice, vertex, press) if vertex is not None else add(editor, lattice, press)


def move(editor: Editor, lattice: LatticeVertices, vertex: int, press: Press) -> Gesture:
    """Move a vertex with the pointer; the pattern is found anew when it is let go."""
    first = yield from drag_from(press.pos)
    if first is not None:
        with editor.group("Move lattice vertex"):
            yield from _follow(editor, lattice, vertex, first)


def add(editor: Editor, lattice: LatticeVertices, press: Press) -> Gesture:
    """Put a vertex where the lattice has room for one beside another, and move it while the button is held."""
    place = _place(editor, press.pos)
    key = free_key(editor, lattice, press.pos)
    if key is None:
        editor.notify("A vertex can be added beside the lattice, about one texel from another one")
        return
    wider = LatticeVertices(np.vstack([lattice.keys, key]), np.vstack([lattice.places, place]))
    with editor.group("Add lattice vertex"):
        _show(editor, wider)
        first = yield from drag_from(press.pos)
        if first is not None:
            yield from _follow(editor, wider, len(wider.keys) - 1, first)


def _follow(editor: Editor, lattice: LatticeVertices, vertex: int, first: Move) -> Gesture:
    event: Event = first
    while isinstance(event, Move):
        places = lattice.places.copy()
        places[vertex] = _place(editor, event.pos)
        _show(editor, LatticeVertices(lattice.keys, places))
        event = yield


def remove(editor: Editor, lattice: LatticeVertices, vertex: int) -> None:
    """Take a vertex out."""
    with editor.group("Remove lattice vertex"):
        _show(
            editor,
            LatticeVertices(np.delete(lattice.keys, vertex, axis=0), np.delete(lattice.places, vertex, axis=0)),
        )
    editor.show(hover=None)


def _show(editor: Editor, lattice: LatticeVertices) -> None:
    """Make `lattice` what the pattern is found from."""
    search = editor.document.cloth.search or Search(seed=editor.document.cloth.seed)
    editor.document = editor.document.with_cloth(search=replace(search, lattice=lattice, texel=None))


def free_key(editor: Editor, lattice: LatticeVertices, pos: Position) -> Points | None:
    """Return the lattice coordinates (2,) that a new vertex at a screen position would have; None where it fits not."""
    points = on_screen(editor, lattice)
    taken = {(int(i), int(j)) for i, j in np.rint(lattice.keys)}
    for row in np.argsort(np.hypot(*(points - pos).T))[:6]:
        basis = local_basis(lattice.keys, points, int(row))
        if basis is None:
            continue
        away = np.linalg.solve(basis, np.asarray(pos) - points[row])
        step = np.rint(away)
        key = np.rint(lattice.keys[row]) + step
        fits = np.abs(step).max() == 1 and np.abs(away - step).max() <= FITS
        if fits and (int(key[0]), int(key[1])) not in taken:
            return np.asarray(key, np.float64)
    return None


def local_basis(keys: Points, points: Points, row: int) -> Floats | None:
    """Return the lattice vectors (2, 2) about a vertex, fitted to the vertices at most two steps away."""
    offsets = keys - keys[row]
    near = np.abs(offsets).max(1) <= 2
    if np.linalg.matrix_rank(offsets[near]) < 2:
        return None
    fitted, *_ = np.linalg.lstsq(offsets[near], points[near] - points[row], rcond=None)
    return np.asarray(fitted.T, np.float64) if abs(np.linalg.det(fitted)) > 1e-6 else None


def _place(editor: Editor, pos: Position) -> Points:
    """Return the normalised place (1, 2) of a screen position."""
    return places_from_pixels(editor.document.size_px, canvas_from_screen(editor.session.view, np.array([pos])))


def hover(editor: Editor, pos: Position) -> object:
    """Return the number of the vertex under the pointer."""
    lattice = vertices(editor)
    return None if lattice is None or not len(lattice.keys) else nearest(on_screen(editor, lattice), pos)


def take_key(editor: Editor, key: Key) -> bool:
    """Remove the vertex under the pointer."""
    lattice, vertex = vertices(editor), editor.session.hover
    if key.name not in ("delete", "backspace") or lattice is None or not isinstance(vertex, int):
        return False
    if vertex < len(lattice.keys):
        remove(editor, lattice, vertex)
    return True


def lattice_shapes(editor: Editor) -> list[Shape]:
    """Return the lattice's lines; quads that the pattern explains badly are marked.

    While the pattern is sought anew they are those of the lattice that grows.
    """
    lattice, search = vertices(editor), editor.document.cloth.search
    grows = search is not None and search.lattice is None and editor.overlay.stage_lattice is not None
    if lattice is None or len(lattice.keys) < 2 or (grows and not editor.overlay.is_final):
        return _stage_shapes(editor)
    web, points = web_of(lattice, editor.document.size_px), on_screen(editor, lattice)
    lines: list[Shape] = [Polyline(points[rows], "lattice") for rows in web.chains]
    layers = editor.overlay.layers
    if editor.overlay.is_final and layers is not None and len(layers.lattice) == len(points):
        weak = points[web.quads(layers.lattice.frames.scores < WEAK)]
        lines.extend(Polyline(quad, "lattice-weak", closed=True) for quad in weak)
    return lines


def _stage_shapes(editor: Editor) -> list[Shape]:
    """Return the lattice that the search has so far."""
    found = editor.overlay.stage_lattice
    if found is None:
        return []
    keys, points = found
    seen = screen_from_canvas(editor.session.view, points)
    return [Polyline(seen[rows], "lattice") for rows in Web(keys, points).chains]


def overlay(editor: Editor) -> Sequence[Shape]:
    """Draw the lattice and, where there is room, its vertices."""
    shapes = lattice_shapes(editor)
    lattice = vertices(editor)
    if lattice is None or not len(lattice.keys):
        return shapes
    points, view = on_screen(editor, lattice), editor.session.view
    inside = ((points >= 0) & (points <= view.size)).all(1)
    step = web_of(lattice, editor.document.size_px).step * view.zoom
    radius = float(np.clip(0.12 * step, 0, VERTEX_PX))
    if radius >= LEAST_VERTEX_PX:
        hovered, places = editor.session.hover, points.tolist()
        for row in np.flatnonzero(inside).tolist():
            x, y = places[row]
            if row == hovered:
                shapes.append(Circle((x, y), radius + 3, "hover"))
            shapes.append(Circle((x, y), radius, "vertex", filled=True))
    return shapes


LATTICE = Tool(
    name="lattice",
    label="Lattice",
    icon="border-none",
    key="l",
    hint="Drag a vertex to where the pattern repeats · click beside the lattice to add one · Alt-click removes",
    press=press,
    modes=frozenset(("overlay",)),
    cursor="cross",
    hover=hover,
    take_key=take_key,
    overlay=overlay,
)
