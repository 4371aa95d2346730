"""The pen: draws a new curve, knot by knot. A click makes a corner, a drag a smooth knot with handles."""

import itertools
from dataclasses import dataclass

import numpy as np

from app.editor.editor import Editor
from app.model.events import Event, Finish, Key, Move, Position, Press, Release
from app.model.gestures import Gesture
from app.model.spaces import canvas_from_screen, screen_from_canvas
from app.tools.curves.curve_set import EditedCurves
from app.tools.points.grips import REACH_PX, held_to_axis, is_click
from core.arrays import Points
from core.curves import curve_edit
from core.document.document import CurvePair, places_from_pixels


@dataclass
class Knot:
    """A knot of the path in progress, in canvas pixels."""

    place: Points
    before: Points
    after: Points
    corner: bool = True


@dataclass
class Path:
    """The path in progress."""

    knots: list[Knot]
    closed: bool = False

    def points(self, pointer: Points | None = None) -> Points:
        """Return the control points (3k + 1, 2); with `pointer`, a segment leads on to there."""
        if not self.knots:
            return np.empty((0, 2))
        knots = [*self.knots, *([] if pointer is None else [Knot(pointer, pointer, pointer)])]
        knots += self.knots[:1] if self.closed else []
        pieces = [knots[0].place[None]]
        for a, b in itertools.pairwise(knots):
            # A handle that lies on its knot could not be gripped: on a straight segment it goes a third of the way.
            leave = a.after if (a.after != a.place).any() else a.place + (b.before - a.place) / 3
            arrive = b.before if (b.before != b.place).any() else b.place + (a.after - b.place) / 3
            pieces.append(np.stack([leave, arrive, b.place]))
        return np.concatenate(pieces)


def draw(editor: Editor, curves: EditedCurves, press: Press) -> Gesture:
    """Draw a curve until Enter, a double click, or a click on its first knot, which closes it.

    Where that makes none, the curve that was edited before is edited on.
    """
    path, mesh = Path([]), curves.seen_through(editor)
    before = {"selected_curve": curves.selected(editor), "selected_knots": curves.knots(editor)}
    editor.show(selected_curve=None, selected_knots=frozenset())
    try:
        yield from _draw(editor, path, press)
    except GeneratorExit:
        editor.show(**before)
        raise
    finally:
        editor.show(draft=None, draft_handles=None)
    canvas = path.points()
    if len(path.knots) < 2 or curve_edit.curve_through(canvas) is None:
        editor.show(**before)
        return
    with editor.group("Draw curve"):
        source = curves.source_places(editor, mesh, screen_from_canvas(editor.session.view, canvas))
        target = places_from_pixels(editor.canvas_px, canvas)
        corners = frozenset(number for number, knot in enumerate(path.knots) if knot.corner)
        pair = CurvePair(source, target, closed=path.closed, corners=corners)
        editor.document = curves.kind.put(editor.document, (*curves.pairs(editor), pair))
    editor.show(selected_curve=len(curves.pairs(editor)) - 1, selected_knots=frozenset())
    if curves.kind.mode == "retexture" and editor.session.snaps_curves:
        # An undo entry of its own: the artist may take it back alone.
        curves.kind.snap(editor)


def _draw(editor: Editor, path: Path, press: Press) -> Gesture:
    """Take the events that make the path."""
    event: Event = press
    pressed: Position | None = None
    while not isinstance(event, Finish) and not (isinstance(event, Key) and event.name == "enter"):
        if isinstance(event, Press):
            if event.clicks > 1 or event.button == "right":
                return
            pressed = event.pos
            path.closed = _closes(editor, path, event.pos)
            if not path.closed:
                _add(editor, path, event)
        elif isinstance(event, Move) and pressed is not None and not is_click(pressed, event.pos):
            _pull(editor, path, event)
        elif isinstance(event, Release):
            pressed = None
            if path.closed:
                return
        elif isinstance(event, Key):
            path.knots = path.knots[:-1]
            if not path.knots:
                return
        _show(editor, path, event, is_held=pressed is not None)
        event = yield


def _closes(editor: Editor, path: Path, pos: Position) -> bool:
    """Return whether a press at `pos` is on the first knot of a path that can be closed."""
    if len(path.knots) < 2:
        return False
    first = screen_from_canvas(editor.session.view, path.knots[0].place)
    return bool(np.hypot(*(first - pos)) <= REACH_PX)


def _add(editor: Editor, path: Path, press: Press) -> None:
    """Add a knot; with Shift level with the last one, or above or below it."""
    pos = press.pos
    if press.mods.shift and path.knots:
        x, y = screen_from_canvas(editor.session.view, path.knots[-1].place)
        pos = held_to_axis((float(x), float(y)), pos)
    place = canvas_from_screen(editor.session.view, np.array(pos))
    if path.knots and (place == path.knots[-1].place).all():
        return
    path.knots.append(Knot(place, place, place))


def _pull(editor: Editor, path: Path, move: Move) -> None:
    """Pull the handles out of the last knot; of the first one when it closes the path. Alt leaves the one before."""
    knot = path.knots[0 if path.closed else -1]
    after = canvas_from_screen(editor.session.view, np.array(move.pos))
    if path.closed:
        knot.before = 2 * knot.place - after
        if not move.mods.alt and not knot.corner:
            knot.after = after
        return
    knot.after, knot.corner = after, move.mods.alt
    if not move.mods.alt:
        knot.before = 2 * knot.place - after


def _show(editor: Editor, path: Path, event: Event, *, is_held: bool) -> None:
    """Show the path so far, the handles that are pulled out, and where the next segment would go."""
    pointer = canvas_from_screen(editor.session.view, np.array(event.pos)) if isinstance(event, Move) else None
    points = path.points(None if is_held or path.closed else pointer)
    pulled = path.knots[0 if path.closed else -1] if is_held else None
    handles = None if pulled is None else np.stack([pulled.before, pulled.place, pulled.after])
    editor.show(draft=points, draft_handles=handles)
