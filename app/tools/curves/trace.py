"""Trace with help: a path that clings to edges between clicks, an outline from a rectangle, and suggested curves."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from app.editor.curve_kinds import with_found_curve
from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.events import Event, Finish, Key, Move, Position, Press
from app.model.gestures import Gesture, resume
from app.model.shapes import Bezier, Polyline, Shape, Square
from app.model.spaces import canvas_from_screen, screen_from_canvas
from app.tools.curves.curves import FEATURE_CURVE_TOOL, FEATURE_CURVES
from app.tools.points.grips import REACH_PX, drag_from
from core.arrays import InputError, Points
from core.curves.bezier import Curve
from core.curves.edge_tracing import Scissors, object_outline
from core.curves.fitting import fit
from core.document.document import pixels_from_places
from core.document.retexture import moves

TOLERANCE_PX = 2.0
"""A traced curve keeps so close to its path, in pixels as they are seen, and in the picture's at least."""
LINE_REACH_PX = 7.0


@dataclass
class Trace:
    """The path in progress, in pixels of the picture."""

    scissors: Scissors
    tolerance_px: float
    anchors: list[Points] = field(default_factory=list)
    pieces: list[Points] = field(default_factory=list)
    closed: bool = False

    def line(self, further: Points | None = None) -> Points:
        """Return the path (n, 2), with a further piece if there is one."""
        pieces = [*self.pieces, *([] if further is None else [further])]
        return np.concatenate(pieces) if pieces else np.reshape(self.anchors[:1], (-1, 2))

    def curve(self, further: Points | None = None) -> Curve | None:
        """Return the curve along the path; None where that is a single point."""
        try:
            return fit(self.line(further), tolerance=self.tolerance_px, closed=self.closed)
        except InputError:
            return None


def press(editor: Editor, event: Press) -> Gesture | None:
    """Take a suggestion, or trace; what is traced is the picture as it was."""
    number = suggestion_at(editor, event.pos)
    if number is not None:
        take_suggestion(editor, number)
        return None
    if editor.session.look != "original" and moves(editor.document):
        editor.show(look="original")
        editor.notify("Tracing follows the original picture.")
        return None
    return begin(editor, event)


def begin(editor: Editor, event: Press) -> Gesture:
    """Trace from a click on; drag a curve that is there, or a rectangle in which an object is looked for."""
    first = yield from drag_from(event.pos)
    if first is None:
        yield from trace(editor, event)
    elif FEATURE_CURVES.hit(editor, event.pos) is not None:
        editor.show(tool=FEATURE_CURVE_TOOL.name, hover=None)
        yield from resume(FEATURE_CURVE_TOOL.press(editor, event), first)
    else:
        yield from cut_out(editor, event, first)


def trace(editor: Editor, event: Press) -> Gesture:
    """Follow the edges from click to click until Enter, a double click, or a click on the first anchor."""
    zoom = editor.session.view.zoom
    path = Trace(Scissors(editor.document.image, scale=zoom), max(TOLERANCE_PX, TOLERANCE_PX / zoom))
    editor.show(selected_curve=None, selected_knots=frozenset())
    try:
        yield from _follow(editor, path, event)
    finally:
        editor.show(draft=None)
    curve = path.curve() if path.pieces else None
    if curve is not None:
        add_curve(editor, "Trace curve", curve)


def _follow(editor: Editor, path: Trace, event: Event) -> Gesture:
    """Take the events that make the path."""
    while not isinstance(event, Finish) and not (isinstance(event, Key) and event.name == "enter"):
        if isinstance(event, Press):
            if event.clicks > 1 or event.button == "right":
                return
            _anchor(editor, path, event)
            if path.closed:
                return
        elif isinstance(event, Key):
            path.anchors, path.pieces = path.anchors[:-1], path.pieces[:-1]
            if not path.anchors:
                return
            path.scissors.begin(path.anchors[-1])
        further = _piece(editor, path, event) if isinstance(event, Move) else None
        curve = path.curve(further)
        editor.show(draft=None if curve is None else curve.points)
        event = yield


def _piece(editor: Editor, path: Trace, event: Press | Move) -> Points:
    """Return the path from the last anchor to the pointer: along edges, with Ctrl straight."""
    place = canvas_from_screen(editor.session.view, np.array(event.pos))
    return np.stack([path.anchors[-1], place]) if event.mods.ctrl else path.scissors.path_to(place)


def _anchor(editor: Editor, path: Trace, event: Press) -> None:
    """Hold the path at a click; on the first anchor it closes."""
    place = canvas_from_screen(editor.session.view, np.array(event.pos))
    if path.anchors:
        first = screen_from_canvas(editor.session.view, path.anchors[0])
        path.closed = len(path.pieces) > 1 and bool(np.hypot(*(first - event.pos)) <= REACH_PX)
        end = path.anchors[0] if path.closed else place
        piece = np.stack([path.anchors[-1], end]) if event.mods.ctrl else path.scissors.path_to(end)
        path.pieces.append(piece)
        place = piece[-1]
    path.anchors.append(path.scissors.begin(place))


def cut_out(editor: Editor, press: Press, event: Event) -> Gesture:
    """Drag a rectangle around an object; its outline becomes a curve."""
    try:
        while isinstance(event, Move):
            corners = np.array([press.pos, event.pos])
            editor.show(band=(press.pos, event.pos))
            event = yield
    finally:
        editor.show(band=None)
    canvas = canvas_from_screen(editor.session.view, corners)
    image = editor.document.image

    def deliver(curve: Curve) -> None:
        if editor.document.image is image:
            add_curve(editor, "Outline object", curve)

    editor.background("Outline object", lambda: object_outline(image, canvas.min(axis=0), canvas.max(axis=0)), deliver)


def add_curve(editor: Editor, label: str, curve: Curve) -> None:
    """Add a curve, and take the tool that drags it; not where another mode has been chosen meanwhile."""
    with editor.group(label):
        editor.document = with_found_curve(editor, editor.document, curve)
    if editor.session.mode == "retexture":
        number = len(editor.document.feature_curves) - 1
        editor.show(tool="feature-curves", selected_curve=number, selected_knots=frozenset(), hover=None)


def suggestion_at(editor: Editor, pos: Position) -> int | None:
    """Return the number of the suggested curve under `pos`."""
    view, size = editor.session.view, editor.document.size_px
    place = canvas_from_screen(view, np.array([pos]))
    away = [
        Curve(pixels_from_places(size, points)).nearest(place)[1][0] * view.zoom
        for points in editor.session.suggestions
    ]
    best = int(np.argmin(away)) if away else None
    return best if best is not None and away[best] <= LINE_REACH_PX else None


def take_suggestion(editor: Editor, number: int) -> None:
    """Make a suggested curve a feature curve; the others stay on offer."""
    offered = list(editor.session.suggestions)
    points = pixels_from_places(editor.document.size_px, offered.pop(number))
    with editor.group("Take suggested curve"):
        editor.document = with_found_curve(editor, editor.document, Curve(points))
    count = len(editor.document.feature_curves)
    editor.show(suggestions=tuple(offered), selected_curve=count - 1, selected_knots=frozenset(), hover=None)


def take_key(editor: Editor, key: Key) -> bool:
    """Put the suggestions away."""
    if key.name == "escape" and editor.session.suggestions:
        editor.show(suggestions=())
        return True
    return False


def moment(editor: Editor) -> str:
    """Return what can be done while a path is being traced, or while curves are on offer."""
    if editor.session.draft is not None:
        return (
            "Click to hold the path · Ctrl goes straight · Backspace takes one back · click the first to close · Enter"
        )
    return "Click a dashed curve to take it · Esc puts the others away" if editor.session.suggestions else ""


def hover(editor: Editor, pos: Position) -> object:
    """Return the number of the suggested curve under the pointer."""
    return suggestion_at(editor, pos)


def overlay(editor: Editor) -> Sequence[Shape]:
    """Draw the feature curves, what is suggested, and what is being traced."""
    session = editor.session
    shapes: list[Shape] = [
        Bezier(FEATURE_CURVES.on_screen(editor, pair, "source"), "passive" if pair.passive else "target")
        for pair in editor.document.feature_curves
    ]
    for number, points in enumerate(session.suggestions):
        shown = screen_from_canvas(session.view, pixels_from_places(editor.document.size_px, points))
        shapes.append(Bezier(shown, "hover" if number == session.hover else "suggestion", dashed=True))
    if session.draft is not None:
        points = screen_from_canvas(session.view, session.draft)
        first: tuple[float, float] = (float(points[0, 0]), float(points[0, 1]))
        shapes += [Bezier(points, "target"), Square(first, 4.0, "knot", filled=True)]
    if session.band is not None:
        (left, top), (right, bottom) = session.band
        corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
        shapes.append(Polyline(corners, "rubber-band", closed=True))
    return shapes


TRACE = Tool(
    name="trace",
    label="Trace edges",
    icon="wand-magic-sparkles",
    key="t",
    hint="Click along an edge, Enter ends · Ctrl goes straight · drag a rectangle around an object · click suggestions",
    press=press,
    modes=frozenset(("retexture",)),
    hover=hover,
    take_key=take_key,
    moment=moment,
    on_original=True,
    overlay=overlay,
)
