"""The panel of Warp mode: which warp, how strong, what is kept and how strictly, and on which grid."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, cast

from imgui_bundle import ImVec2, imgui

from app.actions.warp import choose_preset
from app.editor.editor import Editor
from app.ui.panels.preset_list import PresetList
from app.ui.panels.resize import ResizePanel
from app.ui.panels.space import SpacePanel
from app.ui.panels.straight_lines import draw_straight
from app.ui.widgets.controls import check, faint, label, section, segments
from app.ui.widgets.key_button import key_button
from app.ui.widgets.sliders import Held, slider
from core.document import perspective
from core.document.animated import NUMBERS
from core.document.document import Keep, Method, WarpSettings
from core.grid import Grid
from core.warps.presets import PRESETS, Parameter

DEFAULTS = WarpSettings()

KEEPS = (
    ("similarity", "Similar", "Each feature moves, turns and scales as a whole"),
    ("rigid", "Rigid", "Each feature only moves and turns: its size stays"),
    ("none", "Plain", "Features are warped like everything else"),
)
METHODS = (
    ("exact", "Exact", "Features keep their shape to the last digit"),
    ("per-quad", "Per quad", "Features keep their shape by weight, as in the paper"),
)
PAGES = (
    ("bend", "Bend", "Warp the picture by a preset, its outline, pins and curves"),
    ("resize", "Resize", "Give the result another size and aspect ratio; what is painted keeps its shape"),
    (
        "space",
        "In space",
        "Lay the picture on a sphere, a mug or another surface, where features keep their shape",
    ),
)
PAGE_OF_TOOL: dict[str, Literal["bend", "resize"]] = {
    "resize": "resize",
    "outline": "bend",
    "pins": "bend",
    "curves": "bend",
}
AXES = (
    ("across", "Across", "Bend along the width"),
    ("down", "Down", "Bend along the height"),
)


@dataclass(frozen=True)
class WarpRow:
    """A slider for a number of `WarpSettings`."""

    name: str
    field: Literal["bend", "horizontal", "vertical", "weight", "falloff"]
    low: float
    high: float
    hint: str
    digits: int = 0


BEND = WarpRow("Bend", "bend", -100, 100, "How strongly the picture bends, per cent")
DISTORTIONS = (
    WarpRow("Horizontal", "horizontal", -100, 100, "Perspective from side to side, per cent"),
    WarpRow("Vertical", "vertical", -100, 100, "Perspective from top to bottom, per cent"),
)
STRICTNESS = (
    (
        WarpRow("Weight", "weight", 1, 100, "How much more features count than the rest"),
        "How hard what lies beside a feature is drawn along with it: more keeps its surroundings stiffer, too.",
    ),
    (
        WarpRow("Falloff ρ", "falloff", 0, 20, "How far around a feature the weight fades, in cells", 1),
        "How far around a feature that reaches, in cells of the grid; 0 ends it at the feature's edge.",
    ),
)
ABOUT_METHOD = (
    "Exact keeps every feature's shape to the last digit. Per quad is the method as published: each cell of a feature "
    "is held by weight, and large bends still show in it."
)
ABOUT_GRID = "The picture bends in cells: smaller ones follow fine masks and tight bends, and take longer to solve."


class WarpPanel:
    """Sliders and choices over `Document.warp`, and the list of presets."""

    def __init__(self, editor: Editor, presets: PresetList, space: SpacePanel) -> None:
        self._editor = editor
        self._presets = presets
        self._space = space
        self._resize = ResizePanel(editor)

    def draw(self) -> None:
        """Draw the panel: the page that bends, or the one that resizes."""
        self._draw_pages()
        if self._editor.session.page == "resize":
            self._resize.draw()
            return
        if self._editor.session.page == "space":
            self._space.draw()
            return
        if section("Preset"):
            chosen = self._presets.draw(self._warp.preset or "none")
            if chosen is not None:
                choose_preset(self._editor, chosen)
        if section("Shape"):
            self._draw_shape()
        if section("Features"):
            self._draw_features()
        if section("Advanced", opened=False):
            self._draw_advanced()

    def _draw_pages(self) -> None:
        """Draw the choice of the page; tools that belong to one of them turn to it."""
        editor = self._editor
        page, tool = editor.session.page, editor.session.tool
        turned = page if page == "space" and tool != "resize" else PAGE_OF_TOOL.get(tool, page)
        if turned != editor.session.page:
            editor.show(page=turned)
        chosen = segments("page", PAGES, turned)
        if chosen is not None:
            if chosen != "space":
                editor.choose_tool("resize" if chosen == "resize" else "outline")
            elif tool == "resize":
                editor.choose_tool("pins")
            editor.show(page=chosen)
        imgui.dummy(ImVec2(0, 0))

    @property
    def _warp(self) -> WarpSettings:
        return self._editor.document.warp

    @property
    def _default_cell_px(self) -> float:
        return Grid(*self._editor.document.size_px).cell[0]

    def _draw_shape(self) -> None:
        preset = PRESETS[self._warp.preset or "none"]
        imgui.begin_disabled(not preset.bends)
        self._slide(BEND)
        label("Direction", "Which way the warp runs")
        axis = segments("axis", AXES, "down" if self._warp.vertical_axis else "across")
        imgui.end_disabled()
        if axis is not None:
            self._edit("Warp direction", vertical_axis=axis == "down")
        for row in DISTORTIONS:
            self._slide(row)
        if perspective.has_corners(self._editor.document):
            faint("Drag the picture's corners with the outline tool (O).")
        for parameter in preset.settings:
            self._slide_parameter(parameter)

    def _draw_features(self) -> None:
        if self._editor.document.mask.is_empty:
            faint("Paint over what must keep its shape with the brush (B).")
        label("Keep", "What happens to the painted features")
        keep = segments("keep", KEEPS, self._warp.keep)
        if keep is not None:
            self._edit("Keep features", keep=cast("Keep", keep))
        draw_straight(self._editor)

    def _draw_advanced(self) -> None:
        """Draw what is seldom needed, with a sentence on each."""
        imgui.begin_disabled(self._warp.keep == "none")
        label("Method", "How strictly features keep their shape")
        method = segments("method", METHODS, self._warp.method)
        if method is not None:
            self._edit("Method", method=cast("Method", method))
        faint(ABOUT_METHOD)
        for row, about in STRICTNESS:
            self._slide(row)
            faint(about)
        imgui.end_disabled()
        self._draw_grid()
        faint(ABOUT_GRID)

    def _draw_grid(self) -> None:
        automatic = self._warp.cell_px is None
        switched = check("Automatic", automatic, "A grid of 20 000 to 50 000 nodes")
        cell = self._warp.cell_px or self._default_cell_px
        if switched is not None:
            self._edit("Grid", cell_px=None if switched else cell)
        imgui.begin_disabled(automatic)
        hint = "Side of a grid cell in pixels: smaller is finer and slower"
        held = slider("Cell", cell, 2, 64, default=self._default_cell_px, digits=1, hint=hint)
        imgui.end_disabled()
        self._take("Cell size", held, lambda new: {"cell_px": new})

    def _slide(self, row: WarpRow) -> None:
        """Draw a slider over one number of the settings."""
        value, default = getattr(self._warp, row.field), getattr(DEFAULTS, row.field)
        if row.field in NUMBERS:
            key_button(self._editor, row.field)
        held = slider(row.name, value, row.low, row.high, default=default, digits=row.digits, hint=row.hint)
        self._take(row.name, held, lambda new: {row.field: new})

    def _slide_parameter(self, parameter: Parameter) -> None:
        """Draw a slider over a parameter that only this preset has."""
        key_button(self._editor, parameter.name)
        values, default = self._warp.values, parameter.default
        value, digits = values.get(parameter.name, default), 0 if parameter.unit == "%" else 2
        held = slider(parameter.label, value, parameter.low, parameter.high, default=default, digits=digits)
        self._take(parameter.label, held, lambda new: {"values": {**values, parameter.name: new}})

    def _take(self, name: str, held: Held, changes: Callable[[float], dict[str, object]]) -> None:
        """Show what a slider says while it is held, and make it an undo entry when it is let go."""
        if held.value is not None:
            self._editor.slide(name, self._editor.document.with_warp(**changes(held.value)))
        if held.done:
            self._editor.finish()

    def _edit(self, name: str, **changes: object) -> None:
        self._editor.edit(name, self._editor.document.with_warp(**changes))
