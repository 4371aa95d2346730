"""Actions on outline, pins and inner curves."""

from collections.abc import Callable
from dataclasses import replace

from app.actions import ActionGroup, in_warp
from app.editor.curve_kinds import FEATURE, INNER
from app.editor.editor import Editor
from core.curves import curve_edit
from core.document.document import pixels_from_places, places_from_pixels

_HANDLES = ActionGroup("handles", "Handles", in_warp)


def _toggle_frame(editor: Editor) -> None:
    frame = "free" if editor.document.warp.frame == "held" else "held"
    editor.edit("Free frame" if frame == "free" else "Hold frame", editor.document.with_warp(frame=frame))


def _select_all(editor: Editor) -> None:
    """Select all pins, or with the outline's tool all of its corners: a box then moves, scales and turns them."""
    if editor.session.tool == "outline":
        editor.show(selected_corners=frozenset(range(4)))
    else:
        editor.choose_tool("pins")
        editor.show(selected=frozenset(range(len(editor.document.pins))))


def _has_some_to_select(editor: Editor) -> bool:
    in_warp = editor.session.mode == "warp"
    return in_warp and (editor.session.tool == "outline" or bool(editor.document.pins))


def _toggle_aid(name: str) -> Callable[[Editor], None]:
    """Return what switches one of the aids of the outline."""
    return lambda editor: editor.show(
        outline=replace(editor.session.outline, **{name: not getattr(editor.session.outline, name)})
    )


def put_back(editor: Editor) -> None:
    """Lay the target of the edited curve where the preset has its source."""
    pair, document = INNER.chosen(editor), editor.document
    if pair is not None:
        source = pixels_from_places(document.size_px, pair.source)
        seen = editor.map.base_mesh.canvas_from_image(curve_edit.samples_of(source))
        target = places_from_pixels(document.canvas_px, curve_edit.map_along(source, seen))
        INNER.edit(editor, "Put curve back", replace(pair, target=target))


def toggle_side(editor: Editor) -> None:
    """Edit the sources of curves instead of their targets, or the targets again; sources lie on the original."""
    side = "target" if editor.session.curve_side == "source" else "source"
    editor.show(curve_side=side, look="original" if side == "source" else "retextured", selected_knots=frozenset())


def _has_sources(editor: Editor) -> bool:
    """Return whether a tool of curves is in hand, and there are curves, or their sources are being edited."""
    kind = {"curves": INNER, "feature-curves": FEATURE}.get(editor.session.tool)
    return kind is not None and (bool(kind.of(editor.document)) or editor.session.curve_side == "source")


HANDLES = (
    _HANDLES.action(
        "select_all",
        "Select all",
        _select_all,
        "object-group",
        "Put a box around all pins, or around the whole outline: drag it to move, its corners to scale or turn",
        "Ctrl+A",
        enabled=_has_some_to_select,
    ),
    _HANDLES.action(
        "frame",
        "Let handles move the frame",
        _toggle_frame,
        "crop-simple",
        "Pins and curves draw the picture's edge along",
        checked=lambda editor: editor.document.warp.frame == "free",
    ),
    _HANDLES.action(
        "put_back",
        "Put curve back",
        put_back,
        "arrow-rotate-left",
        "Lay the curve where it lies without handles",
        enabled=lambda editor: INNER.chosen(editor) is not None,
        separated=True,
    ),
    _HANDLES.action(
        "closed",
        "Closed curve",
        INNER.toggle_closed,
        "circle-notch",
        "Join the curve's end to its beginning",
        enabled=lambda editor: INNER.chosen(editor) is not None,
        checked=lambda editor: getattr(INNER.chosen(editor), "closed", False),
    ),
    _HANDLES.action(
        "edit_source",
        "Edit sources of curves",
        toggle_side,
        "location-crosshairs",
        "Edit where curves come from; otherwise where they go",
        "S",
        enabled=_has_sources,
        checked=lambda editor: editor.session.curve_side == "source",
    ),
    _HANDLES.action(
        "mirror_across",
        "Left and right alike",
        _toggle_aid("across"),
        "left-right",
        "What is done to one side of the outline is done to the opposite one, mirrored",
        checked=lambda editor: editor.session.outline.across,
        separated=True,
    ),
    _HANDLES.action(
        "mirror_down",
        "Top and bottom alike",
        _toggle_aid("down"),
        "up-down",
        "What is done to the top of the outline is done to the bottom, mirrored, and the other way round",
        checked=lambda editor: editor.session.outline.down,
    ),
    _HANDLES.action(
        "snap_outline",
        "Snap outline",
        _toggle_aid("snaps"),
        "magnet",
        "Corners, handles and sides come level with the frame, its middle, and corners",
        checked=lambda editor: editor.session.outline.snaps,
    ),
    _HANDLES.removal(
        "reset_outline",
        "Reset outline",
        "vector-square",
        "Give the outline back to the preset",
        {"outline": None},
        separated=True,
    ),
    _HANDLES.removal("remove_pins", "Remove all pins", "thumbtack", "Take all pins out", {"pins": ()}),
    _HANDLES.removal("remove_curves", "Remove all curves", "bezier-curve", "Take all inner curves out", {"curves": ()}),
    _HANDLES.removal(
        "reset",
        "Remove all handles",
        "trash-can",
        "Take outline, pins and curves back",
        {"outline": None, "pins": (), "curves": ()},
    ),
)
