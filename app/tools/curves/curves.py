"""The curve tool: draws inner curves and edits their sources and targets. Warp and Retexture share it."""

from collections.abc import Callable

import numpy as np

from app.editor.curve_kinds import FEATURE, INNER
from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.events import Event, Key, Move, Press
from app.model.gestures import Gesture
from app.tools.curves.curve_set import EditedCurves, Hit, Side
from app.tools.curves.curve_shapes import active_side, box_of, overlay, side_of
from app.tools.curves.kept_edges import leave_edge_out
from app.tools.curves.pen import draw
from app.tools.curves.soft_drag import is_dense, with_knot_pulled
from app.tools.points.box import Box, Grip, apply
from app.tools.points.grips import aim, drag_from, nearest, nudge_px
from app.tools.points.selection import Selection
from core.arrays import Points
from core.curves import curve_edit
from core.document.curves import pairs as curve_pairs
from core.document.document import CurvePair, Mode
from core.mesh import Mesh


def selection(curves: EditedCurves) -> Selection:
    """Return which knots of the selected curve are selected."""
    return Selection("selected_knots", curves.knots)


def press(editor: Editor, curves: EditedCurves, press: Press) -> Gesture | None:
    """Edit what is under the pointer, or draw."""
    hit = curves.hit(editor, press.pos, first=active_side(editor, swapped=press.mods.ctrl))
    if hit is not None and hit.kind == "knot":
        if press.clicks > 1 or press.mods.alt:
            toggle_corner(editor, curves, hit)
            return None
        return drag_knots(editor, curves, press, hit)
    if hit is not None and hit.kind == "handle":
        return drag_handle(editor, curves, press, hit)
    box = box_of(editor, curves)
    grip = box.grip(press.pos) if box is not None else None
    if box is not None and grip is not None and (hit is None or grip.kind != "move" or _is_whole(editor, curves, hit)):
        return transform(editor, curves, press, box, grip)
    if hit is not None:
        return drag_line(editor, curves, press, hit)
    if press.mods.shift and curves.selected(editor) is not None:
        return rubber_band(editor, curves, press)
    if press.mods.alt and leave_edge_out(editor, press.pos):
        return None
    return draw(editor, curves, press)


def _is_whole(editor: Editor, curves: EditedCurves, hit: Hit) -> bool:
    """Return whether all of the curve that was hit is selected, so that its line moves it instead of bending."""
    count = curve_pairs.knots_of(curves.pairs(editor)[hit.curve])
    return hit.curve == curves.selected(editor) and len(curves.knots(editor)) == count


def drag_knots(editor: Editor, curves: EditedCurves, press: Press, hit: Hit) -> Gesture:
    """Move a knot, and the other selected ones if it is selected.

    Where knots stand close together, the curve beside one alone goes along.
    """
    first = yield from selection(curves).grip(editor, press, hit.number)
    if first is None:
        return
    knots = curves.knots(editor)
    pair = curves.pairs(editor)[hit.curve]
    points = curves.on_screen(editor, pair, hit.side)
    gives_way = len(knots) == 1 and is_dense(points)

    def move(points: Points, pair: CurvePair, event: Move) -> Points:
        by = np.subtract(aim(press.pos, event), press.pos)
        if gives_way:
            return with_knot_pulled(points, hit.number, by, closed=pair.closed)
        return curve_edit.with_knots_moved(points, knots, by, closed=pair.closed)

    label = "Move curve point" if len(knots) == 1 else "Move curve points"
    yield from _follow(editor, curves, hit, label, move, first)


def drag_handle(editor: Editor, curves: EditedCurves, press: Press, hit: Hit) -> Gesture:
    """Move a handle; at a smooth knot the one across turns along, unless Alt breaks the knot."""
    pair = curves.pairs(editor)[hit.curve]
    knot = curve_edit.knot_beside(pair.source, hit.number, closed=pair.closed)
    first = yield from drag_from(press.pos)
    if first is None:
        return
    if press.mods.alt or first.mods.alt:
        pair = curve_pairs.with_corner(pair, knot)
    linked = knot not in pair.corners

    def move(points: Points, pair: CurvePair, event: Move) -> Points:
        place = points[hit.number] + np.subtract(aim(press.pos, event), press.pos)
        return curve_edit.with_handle_at(points, hit.number, place, closed=pair.closed, linked=linked)

    yield from _follow(editor, curves, hit, "Move curve handle", move, first, pair)


def drag_line(editor: Editor, curves: EditedCurves, press: Press, hit: Hit) -> Gesture:
    """Bend the curve where it is gripped; a click selects it, and inserts a knot where it is selected already.

    Where knots stand close together, the nearest one is pulled; a knot under the pointer is moved.
    """
    was_selected = curves.selected(editor) == hit.curve
    editor.show(selected_curve=hit.curve, selected_knots=frozenset())
    first = yield from drag_from(press.pos)
    if first is not None:
        pair = curves.pairs(editor)[hit.curve]
        start = curves.on_screen(editor, pair, hit.side)
        gives_way, knot = is_dense(start), nearest(start[::3], press.pos)
        count = curve_pairs.knots_of(pair)
        smooth = frozenset(range(count)) - pair.corners

        def bend(points: Points, pair: CurvePair, event: Move) -> Points:
            by = np.subtract(aim(press.pos, event), press.pos)
            if gives_way:
                return with_knot_pulled(points, round(hit.t), by, closed=pair.closed)
            if knot is not None:
                return curve_edit.with_knots_moved(points, {knot % count}, by, closed=pair.closed)
            return curve_edit.bent(points, hit.t, by, closed=pair.closed, smooth=smooth)

        yield from _follow(editor, curves, hit, "Bend curve", bend, first)
    elif was_selected:
        with editor.group("Insert curve point"):
            pair = curve_pairs.insert(curves.pairs(editor)[hit.curve], hit.t)
            editor.document = curves.replaced(editor.document, hit.curve, pair)
        editor.show(selected_knots=frozenset({int(hit.t) + 1}))


def transform(editor: Editor, curves: EditedCurves, press: Press, box: Box, grip: Grip) -> Gesture:
    """Move, scale or turn the selected knots by their box; a click deselects them."""
    number, side = curves.selected(editor), active_side(editor, swapped=press.mods.ctrl)
    first = yield from selection(curves).grip_box(editor, press)
    if first is None or number is None:
        return
    pair = curves.pairs(editor)[number]
    numbers = curve_edit.points_of(pair.source, curves.knots(editor), closed=pair.closed)

    def move(points: Points, pair: CurvePair, event: Move) -> Points:
        result = points.copy()
        result[numbers] = apply(box.transform(grip, press.pos, event.pos, held=event.mods.shift), points[numbers])
        return result

    label = {"move": "Move curve", "scale": "Scale curve", "turn": "Turn curve"}[grip.kind]
    yield from _follow(editor, curves, Hit(number, side_of(pair, side), "knot"), label, move, first)


def _follow(
    editor: Editor,
    curves: EditedCurves,
    hit: Hit,
    label: str,
    move: Callable[[Points, CurvePair, Move], Points],
    first: Move,
    pair: CurvePair | None = None,
) -> Gesture:
    """Keep a side of a curve at `move(its points at the start, pair, event)`, all on the screen."""
    start = editor.document
    pair = pair or curves.pairs(editor)[hit.curve]
    points = curves.on_screen(editor, pair, hit.side)
    with editor.group(label):
        event: Event = first
        while isinstance(event, Move):
            changed = curves.with_side(editor, pair, hit.side, move(points, pair, event))
            editor.document = curves.replaced(start, hit.curve, changed)
            event = yield


def rubber_band(editor: Editor, curves: EditedCurves, press: Press) -> Gesture:
    """Select knots of the selected curve in a rectangle, beside those that are selected."""
    number = curves.selected(editor)
    if number is None:
        return
    pair = curves.pairs(editor)[number]
    count = curve_edit.knots_of(pair.source, closed=pair.closed)
    knots = lambda: curves.on_screen(editor, pair, side_of(pair, active_side(editor)))[::3][:count]  # noqa: E731
    yield from selection(curves).span(editor, press, knots)


def toggle_corner(editor: Editor, curves: EditedCurves, hit: Hit) -> None:
    """Make a knot a corner, or smooth; where source and target lie apart, only the gripped one changes its shape."""
    pair = curves.pairs(editor)[hit.curve]
    sides: tuple[Side, ...] = ("source", "target") if curves.is_unmoved(editor, pair) else (hit.side,)
    pair = curve_pairs.with_corner_toggled(pair, hit.number, sides)
    label = "Make corner" if hit.number in pair.corners else "Make smooth"
    editor.edit(label, curves.replaced(editor.document, hit.curve, pair))


def remove(editor: Editor, curves: EditedCurves) -> None:
    """Remove the selected knots, or the whole curve where none is selected or fewer than two are left."""
    number, knots = curves.selected(editor), curves.knots(editor)
    if number is None:
        return
    pair: CurvePair | None = curves.pairs(editor)[number] if knots else None
    for knot in sorted(knots, reverse=True):
        pair = curve_pairs.without_knot(pair, knot) if pair is not None else None
    label = "Remove curve" if pair is None else "Remove curve point"
    editor.edit(label, curves.replaced(editor.document, number, pair))
    editor.show(selected_knots=frozenset(), selected_curve=None if pair is None else number)


def take_key(editor: Editor, curves: EditedCurves, key: Key) -> bool:
    """Remove, nudge, select all or deselect."""
    number, step = curves.selected(editor), nudge_px(key)
    if number is None:
        return False
    pair, knots = curves.pairs(editor)[number], curves.knots(editor)
    if key.name == "a" and key.mods.ctrl:
        editor.show(selected_knots=frozenset(range(curve_pairs.knots_of(pair))))
    elif key.name in ("delete", "backspace"):
        remove(editor, curves)
    elif key.name == "escape":
        editor.show(selected_knots=frozenset(), selected_curve=number if knots else None)
    elif step is not None and knots:
        side = side_of(pair, active_side(editor))
        by = step * editor.session.view.zoom
        moved = curve_edit.with_knots_moved(curves.on_screen(editor, pair, side), knots, by, closed=pair.closed)
        changed = curves.with_side(editor, pair, side, moved)
        editor.edit("Nudge curve points", curves.replaced(editor.document, number, changed), joins=True)
    else:
        return False
    return True


def moment(editor: Editor, curves: EditedCurves) -> str:
    """Return what can be done while a curve is being drawn, or with the one that is being edited."""
    if editor.session.draft is not None:
        return (
            "Click for a corner, drag for a smooth point · Backspace takes one back · click the first to close · Enter"
        )
    if curves.selected(editor) is None:
        return ""
    if box_of(editor, curves) is not None:
        return "Drag the box, its corners to scale, its knob to turn · Shift holds axes · arrows nudge · Esc"
    return (
        "Drag points, handles, the line · click the line: new point · double-click: corner, smooth · Ctrl+A: box · Del"
    )


def curve_tool(
    curves: EditedCurves, *, name: str, label: str, icon: str, key: str, modes: frozenset[Mode], hint: str
) -> Tool:
    """Return the tool that draws and edits `curves`."""
    return Tool(
        name=name,
        label=label,
        icon=icon,
        key=key,
        hint=hint,
        press=lambda editor, event: press(editor, curves, event),
        modes=modes,
        hover=lambda editor, pos: curves.hit(editor, pos, first=active_side(editor)),
        take_key=lambda editor, event: take_key(editor, curves, event),
        moment=lambda editor: moment(editor, curves),
        overlay=lambda editor: overlay(editor, curves),
    )


WARP_CURVES = EditedCurves(
    kind=INNER,
    mesh=lambda editor: editor.answer.base_mesh,
    seen_through=lambda editor: editor.answer.mesh,
)
CURVES = curve_tool(
    WARP_CURVES,
    name="curves",
    label="Inner curves",
    icon="bezier-curve",
    key="c",
    modes=frozenset(("warp",)),
    hint="Click and drag to draw, Enter ends · drag points and lines · click a line to add a point · Alt breaks",
)


def _seen(editor: Editor) -> Mesh:
    """Return where the picture is on the canvas of Retexture mode."""
    return editor.regrowth.flat if editor.session.look == "original" else editor.answer.mesh


FEATURE_CURVES = EditedCurves(
    kind=FEATURE,
    mesh=lambda editor: editor.regrowth.flat,
    seen_through=_seen,
    faulty=lambda editor: editor.regrowth.faulty_curve,
)
FEATURE_CURVE_TOOL = curve_tool(
    FEATURE_CURVES,
    name="feature-curves",
    label="Feature curves",
    icon="bezier-curve",
    key="c",
    modes=frozenset(("retexture",)),
    hint="Click and drag to draw, Enter ends · drag the blue target · S edits the source · Alt-click a thin edge",
)
