"""Which curves of a document a tool edits, where they are on the screen, and what of them is under the pointer."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from app.editor.curve_kinds import CurveKind
from app.editor.editor import Editor
from app.model.events import Position
from app.model.spaces import canvas_from_screen, screen_from_canvas
from app.tools.points.grips import nearest, places_from_screen
from core.arrays import Points
from core.curves import curve_edit
from core.document.document import CurvePair, Document, pixels_from_places, places_from_pixels
from core.mesh import Mesh

Side: TypeAlias = Literal["target", "source"]
LINE_REACH_PX = 7.0
SAME_PX = 0.05
"""A target no farther from its source on the screen has not been moved yet."""


@dataclass(frozen=True)
class Hit:
    """What of the curves is under the pointer."""

    curve: int
    side: Side
    kind: Literal["knot", "handle", "line"]
    number: int = 0
    """Of the knot, or of the handle among the control points."""
    t: float = 0.0
    """Parameter of the place on the line."""


@dataclass(frozen=True, eq=False)
class EditedCurves:
    """Curves of one kind in a document, and how their sources lie on the canvas.

    Targets are places on the canvas. Sources are places on the picture and are seen through `mesh`.
    """

    kind: CurveKind
    mesh: Callable[[Editor], Mesh]
    seen_through: Callable[[Editor], Mesh]
    """Where the picture is on the canvas while a new curve is drawn on it."""
    faulty: Callable[[Editor], int | None] = lambda editor: None
    """The number of the curve for which there is no result, if there is one."""

    def pairs(self, editor: Editor) -> tuple[CurvePair, ...]:
        """Return the present curves."""
        return self.kind.of(editor.document)

    def selected(self, editor: Editor) -> int | None:
        """Return the number of the curve that is being edited, if there is one."""
        return self.kind.number(editor)

    def knots(self, editor: Editor) -> frozenset[int]:
        """Return the numbers of the selected knots that there are."""
        number = self.selected(editor)
        if number is None:
            return frozenset()
        pair = self.pairs(editor)[number]
        count = curve_edit.knots_of(pair.source, closed=pair.closed)
        return frozenset(knot for knot in editor.session.selected_knots if knot < count)

    def replaced(self, document: Document, number: int, pair: CurvePair | None) -> Document:
        """Return the document with one curve exchanged, or taken out."""
        return self.kind.replace(document, number, pair)

    def on_canvas(self, editor: Editor, pair: CurvePair, side: Side) -> Points:
        """Return the control points of a side in canvas pixels."""
        if side == "target":
            return pixels_from_places(editor.canvas_px, pair.target)
        pixels = pixels_from_places(editor.document.size_px, pair.source)
        return curve_edit.map_along(pixels, self.mesh(editor).canvas_from_image(curve_edit.samples_of(pixels)))

    def on_screen(self, editor: Editor, pair: CurvePair, side: Side) -> Points:
        """Return the control points of a side in screen pixels."""
        return screen_from_canvas(editor.session.view, self.on_canvas(editor, pair, side))

    def with_side(self, editor: Editor, pair: CurvePair, side: Side, points: Points) -> CurvePair:
        """Return the pair with a side at `points` on the screen; a target that never left its source goes along."""
        if side == "target":
            return replace(pair, target=places_from_screen(editor, points))
        before, source = self.on_screen(editor, pair, "source"), pair.source.copy()
        for start in range(0, len(points) - 1, 3):
            piece = slice(start, start + 4)
            if not np.array_equal(points[piece], before[piece]):
                source[piece] = self.source_places(editor, self.mesh(editor), points[piece])
        changed = replace(pair, source=source)
        return replace(changed, target=places_from_screen(editor, points)) if self.is_unmoved(editor, pair) else changed

    def is_unmoved(self, editor: Editor, pair: CurvePair) -> bool:
        """Return whether the target lies on the source."""
        source, target = self.on_screen(editor, pair, "source"), self.on_screen(editor, pair, "target")
        return bool(np.abs(source - target).max() <= SAME_PX)

    def source_places(self, editor: Editor, mesh: Mesh, points: Points) -> Points:
        """Return places on the picture of a curve on the screen, (3k + 1, 2), as `mesh` shows the picture."""
        canvas = canvas_from_screen(editor.session.view, points)
        found = curve_edit.map_along(canvas, pull_back(mesh, curve_edit.samples_of(canvas)))
        return places_from_pixels(editor.document.size_px, found)

    def hit(self, editor: Editor, pos: Position, *, first: Side = "target") -> Hit | None:
        """Return what is under `pos`: the selected curve's points, then lines; `first` wins where sides coincide.

        Only that side's handles are shown, and can be gripped.
        """
        sides: tuple[Side, Side] = (first, "source" if first == "target" else "target")
        chosen = self.selected(editor)
        pairs = self.pairs(editor)
        if chosen is not None:
            for side in sides_of(pairs[chosen], sides):
                found = self._hit_points(editor, chosen, side, pos, handles=side == sides_of(pairs[chosen], sides)[0])
                if found is not None:
                    return found
        order = sorted(range(len(pairs)), key=lambda number: number != chosen)
        for side in sides:
            for number in order:
                if side in sides_of(pairs[number], sides):
                    t = place_on_line(editor, self.on_canvas(editor, pairs[number], side), pos)
                    if t is not None:
                        return Hit(number, side, "line", t=t)
        return None

    def _hit_points(self, editor: Editor, number: int, side: Side, pos: Position, *, handles: bool) -> Hit | None:
        """Return the knot or, with `handles`, the handle of a curve under `pos`."""
        pair = self.pairs(editor)[number]
        points = self.on_screen(editor, pair, side)
        knot = nearest(points[::3], pos)
        if knot is not None:
            return Hit(number, side, "knot", knot % curve_edit.knots_of(points, closed=pair.closed))
        numbers = np.array([n for n in range(len(points)) if n % 3])
        handle = nearest(points[numbers], pos) if handles else None
        return None if handle is None else Hit(number, side, "handle", int(numbers[handle]))


def place_on_line(editor: Editor, canvas: Points, pos: Position) -> float | None:
    """Return the parameter at which a curve, its points in canvas pixels, passes `pos` on the screen."""
    curve, view = curve_edit.curve_through(canvas), editor.session.view
    if curve is None:
        return None
    t, away = curve.nearest(canvas_from_screen(view, np.array([pos])))
    return float(t[0]) if away[0] * view.zoom <= LINE_REACH_PX else None


def sides_of(pair: CurvePair, sides: tuple[Side, ...]) -> tuple[Side, ...]:
    """Return those of `sides` that the pair has: a passive curve has no target."""
    return tuple(side for side in sides if side == "source" or not pair.passive)


def pull_back(mesh: Mesh, canvas: Points) -> Points:
    """Return picture positions of canvas positions (n, 2); beside the picture they shift like the nearest one on it."""
    found = mesh.image_from_canvas(canvas)
    on = np.flatnonzero(~np.isnan(found).any(axis=1))
    if not len(on):
        return canvas
    for number in np.flatnonzero(np.isnan(found).any(axis=1)):
        closest = on[np.argmin(np.hypot(*(canvas[on] - canvas[number]).T))]
        found[number] = canvas[number] + found[closest] - canvas[closest]
    return found
