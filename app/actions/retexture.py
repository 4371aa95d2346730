"""Actions of Retexture mode: what is shown, the work itself, the feature curves and the masks."""

from collections.abc import Callable
from dataclasses import replace

from app.actions import Action
from app.actions.removal import removal
from app.editor.curve_kinds import FEATURE, with_found_curve
from app.editor.editor import Editor
from app.model.session import Before, Look, Painted
from core.curves.bezier import Curve
from core.curves.edge_tracing import outlines, suggestions
from core.document.curves import pairs as curve_pairs
from core.document.curves.simplifying import simplify_pair
from core.document.document import places_from_pixels
from core.document.retexture import moves
from core.rasters.raster import Raster

SIMPLER_PX = 2.0
"""Simplified curves keep so close to what they were, in pixels as they are seen, and in the picture's at least."""


def in_mode(editor: Editor) -> bool:
    """Return whether the editor is in Retexture mode."""
    return editor.session.mode == "retexture"


def start(editor: Editor) -> None:
    """Regrow the texture, anew where it is there already."""
    editor.finish()
    editor.show(look="retextured")
    editor.regrowth.start(editor.document)


def toggle_auto(editor: Editor) -> None:
    """Switch whether texture is regrown as soon as the artist lets go."""
    editor.show(auto_retexture=not editor.session.auto_retexture)


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


def toggle_snapping(editor: Editor) -> None:
    """Switch whether a curve that was drawn beside an edge is brought onto it."""
    editor.show(snaps_curves=not editor.session.snaps_curves)


def toggle_edges(editor: Editor) -> None:
    """Switch whether long edges near moved curves are kept, all of them."""
    kept = not editor.document.retexture.long_edges
    changed = editor.document.with_retexture(long_edges=kept, left_out=())
    editor.edit("Keep long edges" if kept else "Keep no long edges", changed)


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


def paint(editor: Editor, name: Painted) -> None:
    """Take the brush for one of the masks; where texture is taken from is painted on the picture as it is."""
    editor.choose_tool("brush")
    editor.show(painted=name, look="original" if name == "source_mask" else "retextured")


def show_look(editor: Editor, look: Look) -> None:
    """Show the result in one of its looks, right of the divider where there is one."""
    compare = editor.session.compare
    editor.show(look=look, compare="split" if compare == "split" else "result")


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


_LOOKS: tuple[tuple[Look, str, str, str, str], ...] = (
    ("original", "Original", "1", "image", "The picture as it was"),
    ("deformed", "Deformed", "2", "water", "The picture stretched along with the curves"),
    ("retextured", "Retextured", "3", "brush", "The picture with its texture regrown"),
)


def _look(look: Look, label: str, chord: str, icon: str, tooltip: str) -> Action:
    return Action(
        f"look.{look}",
        label,
        "View/Retexture",
        lambda editor: show_look(editor, look),
        chord,
        icon,
        tooltip,
        enabled=in_mode,
        checked=lambda editor: editor.session.look == look,
    )


def _beside(look: Before, label: str, chord: str, icon: str) -> Action:
    def is_beside(editor: Editor) -> bool:
        return editor.session.compare == "split" and editor.session.look_before == look

    return Action(
        f"look.beside.{look}",
        f"{label} at the left",
        "View/Retexture",
        lambda editor: editor.show(look_before=look, compare="result" if is_beside(editor) else "split"),
        chord,
        icon,
        f"Show {label.lower()} at the left of a line, and what is looked at at the right; drag the line",
        enabled=in_mode,
        checked=is_beside,
    )


def _of_curve(
    name: str, label: str, run: Callable[[Editor], None], icon: str, tooltip: str, switch: str = "", chord: str = ""
) -> Action:
    """Return an action on the edited curve; `switch` is the part of it that says whether it is on."""

    def checked(editor: Editor) -> bool:
        return bool(getattr(FEATURE.chosen(editor), switch, False))

    return Action(
        f"feature.{name}",
        label,
        "Retexture/Curve",
        run,
        chord,
        icon,
        tooltip,
        enabled=lambda editor: FEATURE.chosen(editor) is not None,
        checked=checked if switch else None,
    )


_PAINTED: tuple[tuple[Painted, str, str, str], ...] = (
    ("regrow", "more or less", "seedling", "Paint what is regrown, and with X what is not, whatever is found"),
    ("matte", "matte", "draw-polygon", "Paint where the result may differ from the plain deformation"),
    ("source_mask", "source mask", "eye-dropper", "Paint where texture may be taken from"),
)


def _mask(name: Painted, label: str, icon: str, tooltip: str) -> tuple[Action, ...]:
    return (
        Action(
            f"retexture.paint_{name}",
            f"Paint {label}",
            "Retexture",
            lambda editor: paint(editor, name),
            icon=icon,
            tooltip=tooltip,
            enabled=in_mode,
            checked=lambda editor: editor.session.tool == "brush" and editor.session.painted == name,
            separated=name == "regrow",
        ),
        removal(
            f"retexture.clear_{name}",
            f"Clear {label}",
            "Retexture",
            "retexture",
            "eraser",
            "Nothing painted means everywhere",
            {name: None},
        ),
    )


RETEXTURE = (
    Action(
        "feature.suggest",
        "Suggest curves",
        "Retexture/Curve",
        suggest,
        icon="lightbulb",
        tooltip="Find prominent edges and offer them; click those to take",
        enabled=in_mode,
    ),
    Action(
        "feature.outline",
        "Outline what is painted",
        "Retexture/Curve",
        outline_painted,
        icon="draw-polygon",
        tooltip="Make closed curves around the painted mask",
        enabled=lambda editor: in_mode(editor) and _paint(editor) is not None,
    ),
    *(_look(*row) for row in _LOOKS),
    _beside("original", "Original", "Shift+1", "image"),
    _beside("deformed", "Deformed", "Shift+2", "water"),
    Action(
        "retexture.start",
        "Retexture",
        "Retexture",
        start,
        "Ctrl+R",
        "play",
        "Regrow the texture along the moved curves",
        enabled=lambda editor: in_mode(editor) and moves(editor.document),
    ),
    Action(
        "retexture.auto",
        "Retexture by itself",
        "Retexture",
        toggle_auto,
        icon="bolt",
        tooltip="Regrow the texture as soon as a curve is let go",
        enabled=in_mode,
        checked=lambda editor: editor.session.auto_retexture,
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
    Action(
        "feature.snaps",
        "Snap new curves",
        "Retexture/Curve",
        toggle_snapping,
        icon="magnet",
        tooltip="A curve that is drawn beside an edge comes onto it; undo takes that back alone",
        enabled=in_mode,
        checked=lambda editor: editor.session.snaps_curves,
    ),
    Action(
        "retexture.edges",
        "Keep long edges",
        "Retexture",
        toggle_edges,
        icon="grip-lines",
        tooltip="Rails and the like near the curve stay whole; Alt+click with the curve tool drops one of them",
        enabled=in_mode,
        checked=lambda editor: editor.document.retexture.long_edges,
    ),
    _of_curve("simplify", "Simplify curve", simplify, "bezier-curve", "Take out the points that it does not need"),
    _of_curve("select_all", "Select all points", select_all, "vector-square", "Move, scale and turn it by a box"),
    removal(
        "feature.remove_all",
        "Remove all curves",
        "Retexture/Curve",
        "retexture",
        "trash-can",
        "Take all feature curves out",
        {"feature_curves": ()},
        separated=True,
    ),
    *(action for row in _PAINTED for action in _mask(*row)),
)
