"""Actions on feature curves: found, brought onto edges, edited as a whole."""

from collections.abc import Callable
from dataclasses import replace

from app.actions import Action, ActionGroup
from app.actions.retexture import in_mode
from app.editor.curve_kinds import FEATURE, with_found_curve
from app.editor.editor import Editor
from core.curves.bezier import Curve
from core.curves.edge_tracing import outlines, suggestions
from core.document.curves import pairs as curve_pairs
from core.document.curves.simplifying import simplify_pair
from core.document.document import places_from_pixels
from core.rasters.raster import Raster

_CURVE = ActionGroup("feature", "Retexture/Curve", in_mode)

SIMPLER_PX = 2.0
"""Simplified curves keep so close to what they were, in pixels as they are seen, and in the picture's at least."""


def toggle_passive(editor: Editor) -> None:
    """Leave the edited curve's target out of account, or take it into account again."""
    pair = FEATURE.chosen(editor)
    if pair is not None:
        label = "Give curve a target" if pair.passive else "Make curve passive"
        FEATURE.edit(editor, label, replace(pair, passive=not pair.passive))


def put_back(editor: Editor) -> None:
    """Lay the edited curve's target on its source."""
    pair = FEATURE.chosen(editor)
    if pair is not None:
        FEATURE.edit(editor, "Copy source to target", replace(pair, target=pair.source))


def snap(editor: Editor) -> None:
    """Bring the edited curve onto the edge beside it."""
    editor.finish()
    if not FEATURE.snap(editor):
        editor.notify("The curve is on its edge, or there is none beside it.")


def select_all(editor: Editor) -> None:
    """Select all points of the edited curve, so that a box moves, scales and turns it."""
    pair = FEATURE.chosen(editor)
    if pair is not None:
        editor.show(selected_knots=frozenset(range(curve_pairs.knots_of(pair))))


def simplify(editor: Editor) -> None:
    """Leave the edited curve as few points as keep it, to the eye, where it is."""
    pair = FEATURE.chosen(editor)
    if pair is None:
        return
    tolerance_px = SIMPLER_PX / min(editor.session.view.zoom, 1.0)
    simpler = simplify_pair(pair, editor.document.size_px, tolerance_px=tolerance_px)
    if simpler is pair:
        editor.notify("No point can go without changing the curve.")
        return
    FEATURE.edit(editor, "Simplify curve", simpler)
    editor.show(selected_knots=frozenset(), hover=None)


def suggest(editor: Editor) -> None:
    """Look for prominent edges of the original and offer them."""
    document = editor.document

    def deliver(curves: list[Curve]) -> None:
        if editor.document.image is not document.image or not in_mode(editor):
            return
        offered = tuple(places_from_pixels(document.size_px, curve.points) for curve in curves)
        editor.choose_tool("trace")
        editor.show(suggestions=offered, look="original")
        editor.notify("Click the curves to take." if offered else "No prominent edges found.")

    editor.background("Suggest curves", lambda: suggestions(document.image), deliver)


def outline_painted(editor: Editor) -> None:
    """Make closed feature curves of the outlines of what is painted."""
    raster = _paint(editor)
    found = [] if raster is None else outlines(raster.array)
    document = editor.document
    for curve in found:
        document = with_found_curve(editor, document, curve, on_result=raster is document.matte)
    editor.edit("Outline mask", document)
    if found:
        editor.choose_tool("feature-curves")
        editor.show(selected_curve=len(document.feature_curves) - 1, selected_knots=frozenset())


def _paint(editor: Editor) -> Raster | None:
    """Return the mask of this mode that the brush paints; the features of Warp mode where it is empty."""
    document = editor.document
    masks = (getattr(document, editor.session.painted), document.mask)
    return next((mask for mask in masks if mask is not None and not mask.is_empty), None)


def _of_curve(
    name: str, label: str, run: Callable[[Editor], None], icon: str, tooltip: str, switch: str = "", chord: str = ""
) -> Action:
    """Return an action on the edited curve; `switch` is the part of it that says whether it is on."""

    def checked(editor: Editor) -> bool:
        return bool(getattr(FEATURE.chosen(editor), switch, False))

    return _CURVE.action(
        name,
        label,
        run,
        icon,
        tooltip,
        chord,
        enabled=lambda editor: FEATURE.chosen(editor) is not None,
        checked=checked if switch else None,
    )


FEATURE_CURVES = (
    _CURVE.action(
        "suggest", "Suggest curves", suggest, "lightbulb", "Find prominent edges and offer them; click those to take"
    ),
    _CURVE.action(
        "outline",
        "Outline what is painted",
        outline_painted,
        "draw-polygon",
        "Make closed curves around the painted mask",
        enabled=lambda editor: in_mode(editor) and _paint(editor) is not None,
    ),
    _of_curve(
        "passive",
        "Passive",
        toggle_passive,
        "compass",
        "Its target counts for nothing: it goes along, and steers the texture's direction",
        "passive",
    ),
    _of_curve(
        "closed", "Closed", FEATURE.toggle_closed, "circle-notch", "Join the curve's end to its beginning", "closed"
    ),
    _of_curve("put_back", "Copy source to target", put_back, "arrow-rotate-left", "Lay the target where the curve is"),
    _of_curve("snap", "Snap to edge", snap, "magnet", "Bring the curve onto the edge that it was drawn beside"),
    _CURVE.switch(
        "snaps",
        "Snap new curves",
        "snaps_curves",
        "magnet",
        "A curve that is drawn beside an edge comes onto it; undo takes that back alone",
    ),
    _of_curve("simplify", "Simplify curve", simplify, "bezier-curve", "Take out the points that it does not need"),
    _of_curve("select_all", "Select all points", select_all, "vector-square", "Move, scale and turn it by a box"),
    _CURVE.removal(
        "remove_all",
        "Remove all curves",
        "trash-can",
        "Take all feature curves out",
        {"feature_curves": ()},
        separated=True,
    ),
)
