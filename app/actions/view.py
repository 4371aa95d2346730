"""Actions on what the canvas shows."""

from dataclasses import replace

import numpy as np

from app.actions import Action, ActionGroup, make_toggle
from app.editor.editor import Editor
from app.model.session import Compare, Heat
from app.model.spaces import View, centre, fit_curve, zoom_at
from core.arrays import Points
from core.document.document import Mode, pixels_from_places
from core.document.map import outline_of

_VIEW, _OVERLAY = ActionGroup("view", "View"), ActionGroup("view.overlay", "View/Overlays")
_MODE = ActionGroup("mode", "Mode")

ZOOM_STEP = 1.5


def reach(editor: Editor) -> tuple[Points, Points]:
    """Return the lowest and the highest place of picture, canvas and handles, (2,) each, in canvas pixels."""
    low, high = editor.answer.mesh.bounds
    last = np.array(editor.canvas_px) - 0.5
    places = np.concatenate([[low, high, np.full(2, -0.5), last], _handles(editor)])
    return places.min(axis=0), places.max(axis=0)


def _handles(editor: Editor) -> Points:
    """Return where the handles of Warp mode are (n, 2), in canvas pixels; none where they are not on the canvas."""
    document = editor.document
    if editor.session.mode != "warp" or editor.unwarped.is_shown:
        return np.empty((0, 2))
    rings = [outline_of(document).ring] if editor.session.tool == "outline" or document.outline else []
    pins = np.reshape([pin.to for pin in document.pins], (-1, 2))
    places = np.concatenate([pins, *rings, *(pair.target for pair in document.curves)])
    return pixels_from_places(document.canvas_px, places)


def whole(editor: Editor) -> View:
    """Return the view of the whole of picture and canvas."""
    return fit_curve(editor.session.view, *reach(editor))


def fit(editor: Editor) -> None:
    """Show the whole of picture and canvas."""
    editor.show(view=whole(editor))


def actual_size(editor: Editor) -> None:
    """Show canvas pixels as pixels of the window, the middle of the view held in place."""
    view = editor.session.view
    middle = (np.asarray(view.size) / 2 - view.pan) / view.zoom
    editor.show(view=centre(replace(view, zoom=1 / view.unit), middle))


def zoom(editor: Editor, factor: float) -> None:
    """Zoom about the middle of the view."""
    view = editor.session.view
    editor.show(view=zoom_at(view, factor, (view.size[0] / 2, view.size[1] / 2)))


def toggle_overlay(editor: Editor, name: str) -> None:
    """Switch one of the overlays."""
    overlays = editor.session.overlays
    editor.show(overlays=replace(overlays, **{name: not getattr(overlays, name)}))  # type: ignore[arg-type]


def toggle_compare(editor: Editor, compare: Compare) -> None:
    """Switch a way of comparing before and after."""
    editor.show(compare="result" if editor.session.compare == compare else compare)


_OVERLAYS = {
    "grid": ("Grid", "G", "border-all", "The deformed grid"),
    "mask": ("Mask", "M", "masks-theater", "What is painted with the brush"),
    "handles": ("Handles", "K", "circle-nodes", "Pins, curves and their marks"),
    "outline": ("Outline", "", "vector-square", "The edge of the picture"),
    "folds": ("Folded cells", "", "triangle-exclamation", "Cells of the grid that are turned over"),
    "spines": ("Curvilinear grids", "", "diagram-project", "The curved coordinates that texture is laid along"),
    "patches": ("Patches", "", "vector-square", "The patches that the texture is made of"),
    "regrown": ("Regrown texture", "Shift+Y", "seedling", "What is regrown; the rest is only deformed"),
    "seams": ("Seams", "", "puzzle-piece", "Where patches meet"),
    "compression": ("Compression", "", "compress", "Where the deformation presses the picture together"),
}
_HEATS: tuple[tuple[Heat, str, str, str], ...] = (
    ("scale", "Heat map of scale", "temperature-half", "How much lengths grow or shrink; where both balance, none"),
    ("angle", "Heat map of angles", "compass-drafting", "By how much right angles change"),
    ("area", "Heat map of areas", "chart-area", "How much areas grow or shrink"),
)
OF_MODE: dict[str, Mode] = {
    "grid": "warp",
    "spines": "retexture",
    "patches": "retexture",
    "regrown": "retexture",
    "seams": "retexture",
    "compression": "retexture",
    "outline": "warp",
    "folds": "warp",
}
"""The mode of overlays that others do not have."""


def _overlay(name: str) -> Action:
    label, chord, icon, tooltip = _OVERLAYS[name]
    return _OVERLAY.action(
        name,
        label,
        lambda editor: toggle_overlay(editor, name),
        icon,
        tooltip,
        chord,
        enabled=lambda editor: name not in OF_MODE or editor.session.mode == OF_MODE[name],
        checked=lambda editor: bool(getattr(editor.session.overlays, name)),
    )


def _heat(heat: Heat, label: str, icon: str, tooltip: str) -> Action:
    def toggle(editor: Editor) -> None:
        overlays = editor.session.overlays
        editor.show(overlays=replace(overlays, heat=None if overlays.heat == heat else heat))

    return _OVERLAY.action(
        heat,
        label,
        toggle,
        icon,
        tooltip,
        enabled=lambda editor: editor.session.mode != "overlay",
        checked=lambda editor: editor.session.overlays.heat == heat,
    )


VIEW = (
    _VIEW.action("fit", "Fit picture", fit, "expand", "Show the whole picture", "Ctrl+0"),
    _VIEW.action("actual", "100 %", actual_size, "1:1", "One pixel of the result is one of the screen", "Ctrl+1"),
    _VIEW.action(
        "zoom_in",
        "Zoom in",
        lambda editor: zoom(editor, ZOOM_STEP),
        "magnifying-glass-plus",
        "Show more closely",
        "Ctrl+=",
        more_chords=("Ctrl++", "Ctrl+Shift+="),
    ),
    _VIEW.action(
        "zoom_out",
        "Zoom out",
        lambda editor: zoom(editor, 1 / ZOOM_STEP),
        "magnifying-glass-minus",
        "Show from farther off",
        "Ctrl+-",
    ),
    _VIEW.action(
        "before",
        "Before (hold)",
        lambda editor: editor.show(compare="before"),
        "eye",
        "Show the picture as it was, as long as the key is held",
        "\\",
        checked=lambda editor: editor.session.compare == "before",
        release=lambda editor: editor.show(compare="result"),
        separated=True,
    ),
    _VIEW.action(
        "split",
        "Split before and after",
        lambda editor: toggle_compare(editor, "split"),
        "table-columns",
        "Show before at the left and after at the right of a line; drag it",
        "Shift+\\",
        checked=lambda editor: editor.session.compare == "split",
    ),
    _VIEW.action(
        "onion",
        "Onion skin",
        lambda editor: toggle_compare(editor, "onion"),
        "layer-group",
        "Let the picture as it was shine through the result",
        "Alt+\\",
        checked=lambda editor: editor.session.compare == "onion",
    ),
    _VIEW.action(
        "unwarped",
        "Paint on the picture as it was",
        lambda editor: editor.unwarped.toggle(),
        "image",
        "While painting or selecting, show the picture as it was instead of the warped one",
        "J",
        enabled=lambda editor: editor.session.mode == "warp" and editor.tool.marks,
        checked=lambda editor: editor.session.paints_unwarped,
    ),
    *(_overlay(name) for name in _OVERLAYS),
    *(_heat(*row) for row in _HEATS),
    _VIEW.action(
        "panels",
        "Hide panels",
        lambda editor: editor.show(panels=not editor.session.panels),
        "table-columns",
        "Leave all of the window to the picture",
        "Tab",
        checked=lambda editor: not editor.session.panels,
        separated=True,
    ),
    _VIEW.action(
        "full_screen",
        "Full screen",
        make_toggle("full-screen"),
        "expand",
        "Give the whole screen to the window, or take it back",
        "F11",
    ),
    _VIEW.action(
        "reset_panels",
        "Reset panel layout",
        make_toggle("layout"),
        "table-cells-large",
        "Put all panels back where they were at first",
    ),
)

_MODES: tuple[tuple[Mode, str, str, str], ...] = (
    ("warp", "Warp", "bezier-curve", "Bend the picture and keep its features"),
    ("retexture", "Retexture", "brush", "Move curves and regrow the texture along them"),
    ("overlay", "Overlay", "shirt", "Lay a new pattern into photographed cloth"),
)


MODES = tuple(
    _MODE.choice(mode, label, Editor.choose_mode, lambda editor: editor.session.mode, icon, tooltip, f"Alt+{number}")
    for number, (mode, label, icon, tooltip) in enumerate(_MODES, start=1)
)
