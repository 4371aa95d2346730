"""The bar over the canvas: options of the tool in hand at the left, what is shown at the right."""

from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from app.actions import Action
from app.actions.table import ActionTable
from app.editor import Editor
from app.tools.brush import hardened, sized
from app.ui import theme
from app.ui.controls import colors, icon_button
from app.ui.sliders import bar_slider
from app.ui.theme import em, icon

HEIGHT_EM = 2.7
SIDE_EM = 1.9
"""Height of what stands in the bar."""

SWITCHES = (
    "view.before",
    "view.split",
    "",
    "view.overlay.mask",
    "view.overlay.grid",
    "view.overlay.outline",
    "view.overlay.handles",
    "view.overlay.folds",
    "view.overlay.spines",
    "view.overlay.patches",
    "view.overlay.seams",
    "view.overlay.compression",
    "view.overlay.scale",
    "",
    "view.fit",
    "view.actual",
)
"""Actions at the right of the bar; an empty name leaves a gap. Those that the mode does not have are left out."""
GAP_EM = 0.9

TOOL_ACTIONS = {
    "brush": ("mask.fill", "mask.clear", "mask.invert", "mask.load"),
    "pins": ("handles.select_all", "handles.frame", "handles.remove_pins"),
    "outline": ("handles.select_all", "handles.reset_outline"),
    "curves": ("handles.edit_source", "handles.frame", "handles.remove_curves"),
    "brush in overlay": ("mask.fill", "mask.clear", "mask.invert", "mask.load", "overlay.find"),
    "brush in retexture": (
        "retexture.paint_matte",
        "retexture.paint_source_mask",
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
        """Draw the bar."""
        padding = (em(SIDE_EM) - imgui.get_font_size()) / 2
        imgui.push_style_var(imgui.StyleVar_.frame_padding, ImVec2(em(0.5), padding))
        imgui.set_cursor_pos(ImVec2(em(1.0), (em(HEIGHT_EM) - em(SIDE_EM)) / 2))
        self._draw_tool()
        self._draw_view()
        imgui.pop_style_var()

    def _draw_tool(self) -> None:
        tool = self._editor.tool
        imgui.align_text_to_frame_padding()
        with colors(text=theme.ACCENT):
            imgui.text(icon(tool.icon))
        imgui.same_line(em(2.9))
        imgui.text(tool.label)
        _gap()
        if tool.name == "brush":
            draw_brush(self._editor)
            _gap()
        of_mode = f"{tool.name} in {self._editor.session.mode}"
        for name in TOOL_ACTIONS.get(of_mode, TOOL_ACTIONS.get(tool.name, ())):
            self._draw_button(self._table.by_name[name])
            imgui.same_line(0, em(0.15))

    def _draw_view(self) -> None:
        """Draw the switches of the view, from the right; the first ones give way where there is no room."""
        by_name, editor = self._table.by_name, self._editor
        names = [name for name in SWITCHES if not name or by_name[name].enabled(editor)]
        imgui.same_line(0, 0)
        room = imgui.get_window_width() - imgui.get_cursor_pos_x() - em(1.6)
        while _width(names) > room and names:
            names.pop(0)
        imgui.same_line(imgui.get_window_width() - _width(names) - em(0.8))
        for name in names:
            if not name:
                imgui.dummy(ImVec2(em(GAP_EM - 0.15), 0))
            else:
                self._draw_switch(self._table.by_name[name])
            imgui.same_line(0, em(0.15))

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


def _width(names: list[str]) -> float:
    """Return how wide the switches are in screen pixels."""
    gaps = names.count("")
    return (len(names) - gaps) * em(SIDE_EM + 0.15) + gaps * em(GAP_EM)


def _gap() -> None:
    """Leave room between parts of the bar, with a line in the middle."""
    imgui.same_line(0, 0)
    place, sheet = imgui.get_cursor_screen_pos(), imgui.get_window_draw_list()
    x, height = place.x + em(1), imgui.get_frame_height()
    sheet.add_line((x, place.y), (x, place.y + height), theme.color(theme.EDGE))
    imgui.dummy(ImVec2(em(2), height))
    imgui.same_line(0, 0)


def draw_brush(editor: Editor) -> None:
    """Draw size, hardness and the choice between painting and erasing."""
    brush = editor.session.brush
    size = bar_slider("Size", brush.diameter_px, 1, 1000, unit="px", logarithmic=True)
    if size.value is not None:
        editor.show(brush=sized(brush, round(size.value)))
    imgui.same_line(0, em(1.0))
    hardness = bar_slider("Hardness", 100 * brush.hardness, 0, 100, unit="%")
    if hardness.value is not None:
        editor.show(brush=hardened(brush, hardness.value / 100))
    imgui.same_line(0, em(0.8))
    if icon_button("Paint", "paintbrush", on=not brush.erase, hint="Paint", key="X", size_em=SIDE_EM):
        editor.show(brush=replace(brush, erase=False))
    imgui.same_line(0, em(0.2))
    if icon_button("Erase", "eraser", on=brush.erase, hint="Erase", key="X", size_em=SIDE_EM):
        editor.show(brush=replace(brush, erase=True))
