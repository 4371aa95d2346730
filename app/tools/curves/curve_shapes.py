"""What is drawn of curves: sources, targets, ticks between them, the points of the selected one and its box."""

from collections.abc import Sequence

import numpy as np

from app.editor.editor import Editor
from app.model.events import Position
from app.model.shapes import Bezier, Circle, Polyline, Role, Shape, Square
from app.model.spaces import screen_from_canvas
from app.tools.curves.curve_set import EditedCurves, Hit, Side, sides_of
from app.tools.points import band
from app.tools.points.box import Box
from core.arrays import Bools, Points
from core.curves import curve_edit
from core.document.curves import pairs as curve_pairs
from core.document.document import CurvePair

TICK_GAP_PX = 32.0
"""Marks of correspondence stand about so far apart on the screen, where source and target are farthest apart."""
MOST_TICKS = 24
"""A segment has so many at most."""


def active_side(editor: Editor, *, swapped: bool = False) -> Side:
    """Return the side that is edited where source and target coincide; Ctrl swaps them."""
    chosen = editor.session.curve_side
    return chosen if not swapped else "source" if chosen == "target" else "target"


def side_of(pair: CurvePair, side: Side) -> Side:
    """Return `side`, or the source of a curve that has nothing else."""
    return "source" if pair.passive else side


def box_of(editor: Editor, curves: EditedCurves) -> Box | None:
    """Return the box around the selected knots if they are several; all of them have the whole curve in it."""
    number, knots = curves.selected(editor), curves.knots(editor)
    if number is None:
        return None
    pair = curves.pairs(editor)[number]
    points = curves.on_screen(editor, pair, side_of(pair, active_side(editor)))
    if len(knots) == curve_pairs.knots_of(pair):
        return Box.around(curve_edit.samples_of(points))
    return Box.around(points[[3 * knot for knot in sorted(knots)]])


def overlay(editor: Editor, curves: EditedCurves) -> Sequence[Shape]:
    """Draw every curve, the points of the selected one, its box, and the path in progress."""
    shapes: list[Shape] = []
    chosen = curves.selected(editor)
    for number, pair in enumerate(curves.pairs(editor)):
        shapes.extend(_curve_shapes(editor, curves, pair, is_faulty=number == curves.faulty(editor)))
        if number == chosen:
            shapes.extend(_point_shapes(editor, curves, pair))
    box, draft = box_of(editor, curves), editor.session.draft
    if box is not None:
        shapes.extend(box.shapes())
    if draft is not None and len(draft):
        shapes.extend(_draft_shapes(screen_from_canvas(editor.session.view, draft)))
        shapes.extend(_pulled_shapes(editor))
    shapes.extend(band.shapes(editor))
    hit = editor.session.hover
    if isinstance(hit, Hit) and hit.curve < len(curves.pairs(editor)) and draft is None:
        shapes.extend(_hover_shapes(editor, curves, hit))
    return shapes


def _curve_shapes(editor: Editor, curves: EditedCurves, pair: CurvePair, *, is_faulty: bool) -> list[Shape]:
    """Return source, target and the ticks between them."""
    view, source = editor.session.view, curves.on_canvas(editor, pair, "source")
    if pair.passive:
        return [Bezier(screen_from_canvas(view, source), "faulty" if is_faulty else "passive")]
    target = curves.on_canvas(editor, pair, "target")
    source, target = (screen_from_canvas(view, points) for points in (source, target))
    ticks: list[Shape] = [Polyline(tick, "tick") for tick in ticks_between(source, target)]
    roles: tuple[Role, Role] = ("faulty", "faulty") if is_faulty else ("source", "target")
    return [*ticks, Bezier(source, roles[0], dashed=True), Bezier(target, roles[1])]


def ticks_between(source: Points, target: Points) -> Points:
    """Return lines (n, 2, 2) on the screen between what corresponds on two curves, where they lie apart."""
    a, b, count = curve_edit.curve_through(source), curve_edit.curve_through(target), len(source) // 3
    if a is None or b is None:
        return np.empty((0, 2, 2))
    sampled = np.stack([curve_edit.samples_of(points).reshape(count, -1, 2) for points in (source, target)])
    lengths = np.hypot(*np.moveaxis(np.diff(sampled, axis=2), -1, 0)).sum(axis=2).max(axis=0)
    steps = np.clip(np.rint(lengths / TICK_GAP_PX), 1, MOST_TICKS).astype(int)
    t = np.concatenate([*(np.arange(n) / n + i for i, n in enumerate(steps)), [count]])
    both = np.stack([a.at(t), b.at(t)], axis=1)
    apart: Points = both[(np.hypot(*(both[:, 0] - both[:, 1]).T) > 1) & _spread(both)]
    return apart


def _spread(ticks: Points) -> Bools:
    """Return which of `ticks` (n, 2, 2) along a curve to show, so that on one side at least they stand apart."""
    steps = np.hypot(*np.moveaxis(np.diff(ticks, axis=0), -1, 0)).max(axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)]) // (TICK_GAP_PX / 2)
    return np.concatenate([[True], along[1:] > along[:-1]])


def _point_shapes(editor: Editor, curves: EditedCurves, pair: CurvePair) -> list[Shape]:
    """Return knots and handles of the selected curve; knots of the other side where it lies elsewhere."""
    shapes: list[Shape] = []
    active, chosen = side_of(pair, active_side(editor)), curves.knots(editor)
    count = curve_pairs.knots_of(pair)
    for side in sides_of(pair, ("source", "target")):
        points = curves.on_screen(editor, pair, side)
        for knot in range(count):
            place = _position(points[3 * knot])
            if side == active:
                for handle in curve_edit.handles_at(points, knot, closed=pair.closed):
                    if handle is not None:
                        shapes.append(Polyline(points[[3 * knot, handle]], "link"))
                        shapes.append(Circle(_position(points[handle]), 3.5, "handle", filled=True))
            role: Role = "knot-selected" if side == active and knot in chosen else "knot"
            if knot in pair.corners:
                shapes.append(Square(place, 4.0, role, filled=side == active))
            else:
                shapes.append(Circle(place, 4.5, role, filled=side == active))
    return shapes


def _draft_shapes(points: Points) -> list[Shape]:
    """Return the path in progress, on the screen."""
    knots: list[Shape] = [Square(_position(place), 4.0, "knot", filled=True) for place in points[::3]]
    return [*([Bezier(points, "target")] if len(points) > 1 else []), *knots]


def _pulled_shapes(editor: Editor) -> list[Shape]:
    """Return the handles that the pen pulls out of a knot."""
    if editor.session.draft_handles is None:
        return []
    before, knot, after = screen_from_canvas(editor.session.view, editor.session.draft_handles)
    ends = [end for end in (before, after) if (end != knot).any()]
    links: list[Shape] = [Polyline(np.stack([knot, end]), "link") for end in ends]
    return [*links, *(Circle(_position(end), 3.5, "handle", filled=True) for end in ends)]


def _hover_shapes(editor: Editor, curves: EditedCurves, hit: Hit) -> list[Shape]:
    """Return the mark of what is under the pointer."""
    pair = curves.pairs(editor)[hit.curve]
    points = curves.on_screen(editor, pair, hit.side)
    if hit.kind == "line":
        curve = curve_edit.curve_through(curves.on_canvas(editor, pair, hit.side))
        return (
            [Circle(_position(screen_from_canvas(editor.session.view, curve.at(hit.t))), 4.0, "hover")] if curve else []
        )
    number = 3 * hit.number if hit.kind == "knot" else hit.number
    return [Circle(_position(points[number]), 10.0, "hover")] if number < len(points) else []


def _position(point: Points) -> Position:
    return float(point[0]), float(point[1])
