"""The lattice tool: moves, adds, removes and locks the vertices that the pattern repeats at, and draws seams."""

from collections.abc import Collection, Sequence
from weakref import WeakKeyDictionary

import numpy as np

from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.events import Event, Key, Move, Position, Press
from app.model.gestures import Gesture
from app.model.shapes import Circle, Polyline, Shape
from app.model.spaces import canvas_from_screen, screen_from_canvas
from app.tools.cloth.lattice_edit import LatticeEdit, is_held
from app.tools.cloth.lattice_web import Web, web_of
from app.tools.points import band
from app.tools.points.grips import drag_from, nearest
from app.tools.points.selection import Selection
from core.arrays import Floats, Points
from core.document.document import pixels_from_places, places_from_pixels
from core.document.overlay_layers import OverlayLayers, vertices_of
from core.document.overlay_settings import LatticeVertices

VERTEX_PX, LEAST_VERTEX_PX = 3.5, 1.6
"""Radius of a vertex; smaller where vertices are close together."""
FITS = 0.4
"""A new vertex lies so near where the lattice goes on, in its steps."""
LOCK = "x"
"""The key that locks vertices."""
WEAK = 0.5
"""Confidence below which a quad is marked."""


_FOUND: "WeakKeyDictionary[OverlayLayers, LatticeVertices]" = WeakKeyDictionary()
"""Layers and their lattice, which is drawn in every frame."""


def vertices(editor: Editor) -> LatticeVertices | None:
    """Return the present lattice: the artist's while the rest is being found, else the one that was found, or None."""
    work, search = editor.overlay, editor.document.cloth.search
    if search is not None and not work.is_final:
        if search.mending is not None:
            return search.mending.lattice
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


def selected(editor: Editor) -> frozenset[int]:
    """Return the numbers of the selected vertices that there are."""
    lattice = vertices(editor)
    count = 0 if lattice is None else len(lattice.keys)
    return frozenset(number for number in editor.session.selected_vertices if number < count)


SELECTION = Selection("selected_vertices", selected)


def press(editor: Editor, press: Press) -> Gesture | None:
    """Remove, move or add a vertex, span a rectangle to select some, or draw a seam."""
    lattice = vertices(editor)
    if lattice is None or not len(lattice.keys):
        return None
    if press.mods.ctrl:
        return draw_seam(editor, press)
    vertex = nearest(on_screen(editor, lattice), press.pos)
    if press.mods.alt or press.button == "right":
        if vertex is not None:
            remove(editor, lattice, {vertex})
        return None
    if vertex is not None:
        return move(editor, lattice, vertex, press)
    key = None if press.mods.shift else free_key(editor, lattice, press.pos)
    if key is not None:
        return add(editor, lattice, key, press)
    return SELECTION.span(editor, press, lambda: on_screen(editor, lattice))


def move(editor: Editor, lattice: LatticeVertices, vertex: int, press: Press) -> Gesture:
    """Move a vertex, and the other selected ones if it is selected; what is around follows when it is let go."""
    first = yield from SELECTION.grip(editor, press, vertex)
    if first is not None:
        numbers = sorted(selected(editor))
        with editor.group("Move lattice vertex" if len(numbers) == 1 else "Move lattice vertices"):
            yield from _follow(editor, lattice, numbers, press.pos, first)


def add(editor: Editor, lattice: LatticeVertices, key: Points, press: Press) -> Gesture:
    """Put a vertex where the lattice has room for one beside another, and move it while the button is held."""
    places = np.vstack([lattice.places, _place(editor, press.pos)])
    wider, number = LatticeVertices(np.vstack([lattice.keys, key]), places), len(lattice.keys)
    with editor.group("Add lattice vertex"):
        edit = LatticeEdit.begun(editor)
        edit.show(wider, hold=[number])
        first = yield from drag_from(press.pos)
        if first is not None:
            yield from _follow(editor, wider, [number], press.pos, first, edit)


def _follow(
    editor: Editor,
    lattice: LatticeVertices,
    numbers: Sequence[int],
    start: Position,
    first: Move,
    edit: LatticeEdit | None = None,
) -> Gesture:
    edit, points = edit or LatticeEdit.begun(editor), on_screen(editor, lattice)[list(numbers)]
    event: Event = first
    while isinstance(event, Move):
        places = lattice.places.copy()
        places[list(numbers)] = _places(editor, points + np.subtract(event.pos, start))
        edit.show(LatticeVertices(lattice.keys, places), hold=numbers)
        event = yield


def remove(editor: Editor, lattice: LatticeVertices, numbers: Collection[int]) -> None:
    """Take vertices out; the photo shows there."""
    rest = np.setdiff1d(np.arange(len(lattice.keys)), sorted(numbers))
    if not len(rest):
        editor.notify("The last vertices of a lattice stay")
        return
    with editor.group("Remove lattice vertex" if len(numbers) == 1 else "Remove lattice vertices"):
        LatticeEdit.begun(editor).show(LatticeVertices(lattice.keys[rest], lattice.places[rest]))
    editor.show(hover=None, selected_vertices=frozenset())


def draw_seam(editor: Editor, press: Press) -> Gesture:
    """Draw a line beyond which nothing follows."""
    line = [press.pos]
    try:
        while isinstance(event := (yield), Move):
            line.append(event.pos)
            editor.show(selection=np.array(line, np.float64))
    finally:
        editor.show(selection=None)
    lattice = vertices(editor)
    if len(line) > 1 and lattice is not None:
        with editor.group("Draw seam"):
            LatticeEdit.begun(editor).show(lattice, seam=_places(editor, np.array(line, np.float64)))


def lock(editor: Editor, lattice: LatticeVertices, numbers: Sequence[int]) -> None:
    """Lock vertices where they lie, or where all of them are locked, let them go."""
    locks = not is_held(editor, lattice)[list(numbers)].all()
    with editor.group("Lock lattice vertices" if locks else "Unlock lattice vertices"):
        LatticeEdit.begun(editor).show(lattice, hold=numbers if locks else (), release=() if locks else numbers)


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
    return _places(editor, np.array([pos]))


def _places(editor: Editor, points: Points) -> Points:
    """Return the normalised places (n, 2) of screen positions."""
    return places_from_pixels(editor.document.size_px, canvas_from_screen(editor.session.view, points))


def hover(editor: Editor, pos: Position) -> object:
    """Return the number of the vertex under the pointer."""
    lattice = vertices(editor)
    return None if lattice is None or not len(lattice.keys) else nearest(on_screen(editor, lattice), pos)


def take_key(editor: Editor, key: Key) -> bool:
    """Remove or lock the selected vertices, or another one under the pointer; deselect."""
    lattice, vertex, chosen = vertices(editor), editor.session.hover, selected(editor)
    if lattice is None or key.mods.ctrl or key.mods.alt:
        return False
    if isinstance(vertex, int) and vertex < len(lattice.keys) and vertex not in chosen:
        chosen = frozenset({vertex})
    if key.name in ("delete", "backspace"):
        if chosen:
            remove(editor, lattice, chosen)
    elif key.name == LOCK and chosen:
        lock(editor, lattice, sorted(chosen))
    elif key.name == "escape" and selected(editor):
        editor.show(selected_vertices=frozenset())
    else:
        return False
    return True


def lattice_shapes(editor: Editor) -> list[Shape]:
    """Return the lattice's lines; quads that the pattern explains badly are marked.

    While the pattern is sought anew they are those of the lattice that grows.
    """
    lattice, search = vertices(editor), editor.document.cloth.search
    grows = search is not None and search.lattice is None and editor.overlay.stage_lattice is not None
    if lattice is None or (grows and not editor.overlay.is_final):
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
    """Draw the lattice and, where there is room, its vertices, the seams and the rubber band."""
    shapes = [*lattice_shapes(editor), *seam_shapes(editor), *band.shapes(editor)]
    lattice = vertices(editor)
    if lattice is None or not len(lattice.keys):
        return shapes
    points, view = on_screen(editor, lattice), editor.session.view
    inside = ((points >= 0) & (points <= view.size)).all(1)
    step = web_of(lattice, editor.document.size_px).step * view.zoom
    radius = float(np.clip(0.12 * step, 0, VERTEX_PX))
    if radius >= LEAST_VERTEX_PX:
        hovered, places = editor.session.hover, points.tolist()
        chosen, held = selected(editor), is_held(editor, lattice)
        for row in np.flatnonzero(inside).tolist():
            x, y = places[row]
            if row == hovered:
                shapes.append(Circle((x, y), radius + 3, "hover"))
            if held[row]:
                shapes.append(Circle((x, y), radius + 2, "vertex"))
            shapes.append(Circle((x, y), radius, "pin-selected" if row in chosen else "vertex", filled=True))
    return shapes


def seam_shapes(editor: Editor) -> list[Shape]:
    """Return the seams, and the one that is being drawn."""
    search, line, view = editor.document.cloth.search, editor.session.selection, editor.session.view
    seams = () if search is None or search.mending is None else search.mending.seams
    size_px = editor.document.size_px
    lines = [screen_from_canvas(view, pixels_from_places(size_px, seam)) for seam in seams]
    return [Polyline(seam, "outline", dashed=True) for seam in [*lines, *([] if line is None else [line])]]


LATTICE = Tool(
    name="lattice",
    label="Lattice",
    icon="border-none",
    key="l",
    hint="Drag a vertex to where the pattern repeats · click beside the lattice to add one · Alt-click removes · "
    "drag a rectangle to select · X locks · Ctrl-drag draws a seam",
    press=press,
    modes=frozenset(("overlay",)),
    can_act=lambda editor: editor.document.cloth.search is not None,
    hover=hover,
    take_key=take_key,
    overlay=overlay,
)
