"""The bar over the canvas: options of the tool in hand at the left, what is shown at the right."""

from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from app.actions import Action
from app.actions.table import ActionTable
from app.editor.editor import Editor
from app.tools.brush import harden, resize
from app.ui.menus import draw_item
from app.ui.select_bar import ACTIONS as SELECT_ACTIONS
from app.ui.select_bar import FURTHER, group_part, make_slider
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, icon_button
from app.ui.widgets.overflow import BUTTON_EM, BarPart, count_fitting, draw_menu, draw_parts, extent
from app.ui.widgets.sliders import bar_slider, bar_slider_width
from app.ui.widgets.theme import em, icon

HEIGHT_EM = 2.7
SIDE_EM = 1.9
"""Height of what stands in the bar."""
MENU_TRACK_EM = 8.0
"""Length of sliders in the menu of what the bar has no room for."""

SWITCHES = (
    "view.before",
    "view.split",
    "view.onion",
    "view.unwarped",
    "",
    "view.overlay.mask",
    "view.overlay.grid",
    "view.overlay.outline",
    "view.overlay.handles",
    "view.overlay.folds",
    "view.overlay.spines",
    "view.overlay.patches",
    "view.overlay.regrown",
    "view.overlay.seams",
    "view.overlay.compression",
    "view.overlay.scale",
    "view.overlay.angle",
    "view.overlay.area",
    "",
    "view.fit",
    "view.actual",
)
"""Actions at the right of the bar; an empty name leaves a gap. Those that the mode does not have are left out."""
GAP_EM = 0.9

TOOL_ACTIONS = {
    "brush": ("features.new", "mask.fit", "mask.transparency", "mask.fill", "mask.clear", "mask.invert", "mask.load"),
    "pins": ("handles.select_all", "handles.frame", "handles.remove_pins"),
    "outline": (
        "handles.select_all",
        "handles.mirror_across",
        "handles.mirror_down",
        "handles.snap_outline",
        "handles.reset_outline",
    ),
    "curves": ("handles.edit_source", "handles.frame", "handles.remove_curves"),
    "brush in overlay": (
        "overlay.paint_region",
        "overlay.paint_protected",
        "overlay.paint_covered",
        "mask.fill",
        "mask.clear",
        "mask.invert",
        "mask.load",
        "overlay.find",
    ),
    "brush in retexture": (
        "retexture.paint_regrow",
        "retexture.paint_matte",
        "retexture.paint_source_mask",
        "mask.fit",
        "mask.fill",
        "mask.clear",
        "mask.invert",
        "mask.load",
        "feature.outline",
    ),
    "trace": ("feature.suggest", "feature.outline"),
    "feature-curves": (
        "handles.edit_source",
        "feature.suggest",
        "feature.passive",
        "feature.closed",
        "feature.put_back",
        "feature.simplify",
        "feature.select_all",
        "feature.remove_all",
    ),
    "drape": ("overlay.texture", "overlay.old_pattern"),
    "region": ("overlay.find", "overlay.clear_region"),
    "texel": ("overlay.find",),
    "lattice": ("overlay.find", "view.overlay.handles"),
    "hand": ("view.fit", "view.actual"),
    "zoom": ("view.zoom_in", "view.zoom_out", "view.fit", "view.actual"),
}
"""By tool, or by tool in a mode, the actions that belong to it."""


class OptionsBar:
    """Draws the bar."""

    def __init__(self, editor: Editor, table: ActionTable) -> None:
        self._editor = editor
        self._table = table

    def draw(self) -> None:
        """Draw the bar: where it is short, tracks shrink, then the tool's name goes, then the last parts."""
        padding = (em(SIDE_EM) - imgui.get_font_size()) / 2
        imgui.push_style_var(imgui.StyleVar_.frame_padding, ImVec2(em(0.5), padding))
        left, top = em(1.0), (em(HEIGHT_EM) - em(SIDE_EM)) / 2
        room = imgui.get_window_width() - left - em(0.8)
        view = self._view_parts()
        for track_em, is_named in ((7.0, True), (3.5, True), (3.5, False)):
            tool = self._tool_parts(track_em, is_named=is_named)
            if extent([*tool, *view]) <= room:
                break
        parts = [*tool, *view]
        count = count_fitting(parts, room)
        shown_view = parts[len(tool) : count]
        end = left + room - (em(BUTTON_EM) if count < len(parts) else 0)
        draw_parts(parts[: min(count, len(tool))], left, top)
        draw_parts(shown_view, end - extent(shown_view), top)
        if count < len(parts):
            draw_menu("More options", parts[count:], end, top)
        imgui.pop_style_var()

    def _tool_parts(self, track_em: float, *, is_named: bool) -> list[BarPart]:
        """Return the tool in hand, its settings and its actions."""
        tool = self._editor.tool
        width = em(1.9) + (imgui.calc_text_size(tool.label).x if is_named else 0)
        parts = [BarPart(width, lambda: self._draw_tool(is_named=is_named)), _line()]
        if tool.name == "brush":
            parts += [*brush_parts(self._editor, track_em), _line()]
        if tool.group:
            alike = [other for other in self._editor.tools.values() if other.group == tool.group]
            parts += [group_part(self._editor, other, self._table.chord_of_tool(other.name)) for other in alike]
            parts += [_line(), *make_slider(self._editor, track_em)]
        return parts + [self._action_part(name, self._draw_button) for name in self._tool_actions()]

    def _tool_actions(self) -> tuple[str, ...]:
        tool = self._editor.tool.name
        if self._editor.tool.group:
            of_features = ("features.new",) if self._editor.session.mode == "warp" else ()
            return (
                *SELECT_ACTIONS,
                *FURTHER.get(tool, ()),
                *of_features,
                "mask.transparency",
                "mask.fit",
                "mask.clear",
            )
        return TOOL_ACTIONS.get(f"{tool} in {self._editor.session.mode}", TOOL_ACTIONS.get(tool, ()))

    def _view_parts(self) -> list[BarPart]:
        """Return the switches of the view that the mode has; those among the tool's own actions stand there."""
        by_name, of_tool = self._table.by_name, self._tool_actions()
        return [
            self._action_part(name, self._draw_switch) if name else BarPart(em(GAP_EM), lambda: None)
            for name in ("", *SWITCHES)
            if not name or (by_name[name].enabled(self._editor) and name not in of_tool)
        ]

    def _action_part(self, name: str, draw: Callable[[Action], None]) -> BarPart:
        action = self._table.by_name[name]
        return BarPart(em(SIDE_EM + 0.15), lambda: draw(action), lambda: draw_item(self._editor, action))

    def _draw_tool(self, *, is_named: bool) -> None:
        imgui.align_text_to_frame_padding()
        with colors(text=theme.ACCENT):
            imgui.text(icon(self._editor.tool.icon))
        if is_named:
            imgui.same_line(em(2.9))
            imgui.text(self._editor.tool.label)

    def _draw_button(self, action: Action) -> None:
        """Draw what acts on the tool's own things; what cannot be done now is grey."""
        imgui.begin_disabled(not action.enabled(self._editor))
        on = action.checked is not None and action.checked(self._editor)
        hint, glyph = f"{action.label}\n{action.tooltip}", action.icon or "object-group"
        if icon_button(action.name, glyph, on=on, quiet=True, hint=hint, key=action.chord, size_em=SIDE_EM):
            action.run(self._editor)
        imgui.end_disabled()

    def _draw_switch(self, action: Action) -> None:
        """Draw what switches the view; what lasts as long as its key is held stays on until the next press."""
        on = action.checked is not None and action.checked(self._editor)
        hint = f"{action.label}\n{action.tooltip}"
        if icon_button(action.name, action.icon, on=on, quiet=True, hint=hint, key=action.chord, size_em=SIDE_EM):
            if on and action.release is not None:
                action.release(self._editor)
            else:
                action.try_run(self._editor)


def _line() -> BarPart:
    """Return room between parts of the bar, with a line in the middle."""

    def draw() -> None:
        place, sheet = imgui.get_cursor_screen_pos(), imgui.get_window_draw_list()
        x = place.x + em(1)
        sheet.add_line((x, place.y), (x, place.y + imgui.get_frame_height()), theme.color(theme.EDGE))

    return BarPart(em(2), draw)


def brush_parts(editor: Editor, track_em: float) -> list[BarPart]:
    """Return size, hardness and the choice between painting and erasing."""
    brush = editor.session.brush

    def draw_size(width_em: float) -> None:
        held = bar_slider("Size", brush.diameter_px, 1, 1000, unit="px", logarithmic=True, width_em=width_em)
        if held.value is not None:
            editor.show(brush=resize(brush, round(held.value)))

    def draw_hardness(width_em: float) -> None:
        held = bar_slider("Hardness", 100 * brush.hardness, 0, 100, unit="%", width_em=width_em)
        if held.value is not None:
            editor.show(brush=harden(brush, held.value / 100))

    def draw_paint() -> None:
        if icon_button("Paint", "paintbrush", on=not brush.erase, hint="Paint", key="X", size_em=SIDE_EM):
            editor.show(brush=replace(brush, erase=False))
        imgui.same_line(0, em(0.2))
        if icon_button("Erase", "eraser", on=brush.erase, hint="Erase", key="X", size_em=SIDE_EM):
            editor.show(brush=replace(brush, erase=True))

    size_px = bar_slider_width("Size", "px", width_em=track_em) + em(1.0)
    hardness_px = bar_slider_width("Hardness", "%", width_em=track_em) + em(0.8)
    return [
        BarPart(size_px, lambda: draw_size(track_em), lambda: draw_size(MENU_TRACK_EM)),
        BarPart(hardness_px, lambda: draw_hardness(track_em), lambda: draw_hardness(MENU_TRACK_EM)),
        BarPart(em(2 * SIDE_EM + 0.2), draw_paint, draw_paint),
    ]
