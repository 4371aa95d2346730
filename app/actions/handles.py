"""Actions on outline, pins and inner curves."""

from dataclasses import replace

from app.actions import Action
from app.editor import Editor
from core import curve_edit, curve_pairs
from core.document import CurvePair, pixels_from_places, places_from_pixels


def _toggle_frame(editor: Editor) -> None:
    frame = "free" if editor.document.warp.frame == "held" else "held"
    editor.edit("Free frame" if frame == "free" else "Hold frame", editor.document.with_warp(frame=frame))


def _select_all(editor: Editor) -> None:
    editor.show(selected=frozenset(range(len(editor.document.pins))))


def _curve(editor: Editor) -> CurvePair | None:
    """Return the curve that is being edited."""
    number, curves = editor.session.selected_curve, editor.document.curves
    if editor.session.mode != "warp" or number is None or number >= len(curves):
        return None
    return curves[number]


def _edit_curve(editor: Editor, label: str, pair: CurvePair) -> None:
    number, curves = editor.session.selected_curve, list(editor.document.curves)
    if number is not None:
        curves[number] = pair
        editor.edit(label, editor.document.changed(curves=tuple(curves)))


def put_back(editor: Editor) -> None:
    """Lay the target of the edited curve where the preset has its source."""
    pair, document = _curve(editor), editor.document
    if pair is not None:
        source = pixels_from_places(document.size_px, pair.source)
        seen = editor.answer.base_mesh.canvas_from_image(curve_edit.samples_of(source))
        target = places_from_pixels(document.canvas_px, curve_edit.mapped(source, seen))
        _edit_curve(editor, "Put curve back", replace(pair, target=target))


def toggle_closed(editor: Editor) -> None:
    """Close the edited curve, or open it."""
    pair = _curve(editor)
    if pair is not None:
        changed = curve_pairs.opened(pair) if pair.closed else curve_pairs.closed(pair)
        _edit_curve(editor, "Open curve" if pair.closed else "Close curve", changed)


def toggle_side(editor: Editor) -> None:
    """Edit the sources of curves instead of their targets, or the targets again; sources lie on the original."""
    side = "target" if editor.session.curve_side == "source" else "source"
    editor.show(curve_side=side, look="original" if side == "source" else "retextured", selected_knots=frozenset())


def _closed(editor: Editor) -> bool:
    pair = _curve(editor)
    return pair is not None and pair.closed


HANDLES = (
    Action(
        "handles.select_all",
        "Select all pins",
        "Handles",
        _select_all,
        "Ctrl+A",
        tooltip="Select every pin",
        enabled=lambda editor: bool(editor.document.pins),
    ),
    Action(
        "handles.frame",
        "Let handles move the frame",
        "Handles",
        _toggle_frame,
        icon="crop-simple",
        tooltip="Pins and curves draw the picture's edge along",
        checked=lambda editor: editor.document.warp.frame == "free",
    ),
    Action(
        "handles.put_back",
        "Put curve back",
        "Handles",
        put_back,
        icon="arrow-rotate-left",
        tooltip="Lay the curve where it lies without handles",
        enabled=lambda editor: _curve(editor) is not None,
        separated=True,
    ),
    Action(
        "handles.closed",
        "Closed curve",
        "Handles",
        toggle_closed,
        icon="circle-notch",
        tooltip="Join the curve's end to its beginning",
        enabled=lambda editor: _curve(editor) is not None,
        checked=_closed,
    ),
    Action(
        "handles.edit_source",
        "Edit sources of curves",
        "Handles",
        toggle_side,
        "S",
        "location-crosshairs",
        "Edit where curves come from; otherwise where they go",
        enabled=lambda editor: editor.session.tool in ("curves", "feature-curves"),
        checked=lambda editor: editor.session.curve_side == "source",
    ),
    Action(
        "handles.reset_outline",
        "Reset outline",
        "Handles",
        lambda editor: editor.edit("Reset outline", editor.document.changed(outline=None)),
        icon="vector-square",
        tooltip="Give the outline back to the preset",
        enabled=lambda editor: editor.document.outline is not None,
        separated=True,
    ),
    Action(
        "handles.remove_pins",
        "Remove all pins",
        "Handles",
        lambda editor: editor.edit("Remove pins", editor.document.changed(pins=())),
        icon="thumbtack",
        tooltip="Take all pins out",
        enabled=lambda editor: bool(editor.document.pins),
    ),
    Action(
        "handles.remove_curves",
        "Remove all curves",
        "Handles",
        lambda editor: editor.edit("Remove curves", editor.document.changed(curves=())),
        icon="bezier-curve",
        tooltip="Take all inner curves out",
        enabled=lambda editor: bool(editor.document.curves),
    ),
    Action(
        "handles.reset",
        "Remove all handles",
        "Handles",
        lambda editor: editor.edit("Remove handles", editor.document.changed(outline=None, pins=(), curves=())),
        icon="trash-can",
        tooltip="Take outline, pins and curves back",
        enabled=lambda editor: editor.document.has_handles,
    ),
)
