"""Options of the tools that select, for the bar over the canvas."""

from imgui_bundle import imgui

from app.actions.selecting import set_selecting
from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.pointer_keys import word
from app.tools.brush import resize
from app.ui.widgets.controls import disabled, icon_button
from app.ui.widgets.overflow import BarPart
from app.ui.widgets.sliders import bar_slider, bar_slider_width
from app.ui.widgets.theme import em, icon

SIDE_EM, MENU_TRACK_EM = 1.9, 8.0
ACTIONS = ("select.replace", "select.add", "select.subtract", "select.intersect")
FURTHER = {"wand": ("select.contiguous",), "object": ("select.by_stroke",)}
"""By tool, its own switches."""


def group_part(editor: Editor, tool: Tool, chord: str) -> BarPart:
    """Return the button of a tool beside the others of its group."""
    on = editor.tool.name == tool.name

    def draw() -> None:
        hint = f"{tool.label}\n{word(tool.hint, tool.name, editor.preferences.pointer_keys)}"
        with disabled(not on and not tool.can_act(editor)):
            label = f"in bar {tool.label}"
            pressed = icon_button(label, tool.icon, on=on, quiet=True, hint=hint, key=chord, size_em=SIDE_EM)
        if pressed:
            editor.choose_tool(tool.name)

    def draw_row() -> None:
        label, enabled = f"{tool.label}###in menu {tool.name}", on or tool.can_act(editor)
        if imgui.internal.menu_item_ex(label, icon(tool.icon), chord, on, enabled):
            editor.choose_tool(tool.name)

    return BarPart(em(SIDE_EM + 0.15), draw, draw_row)


def make_slider(editor: Editor, track_em: float) -> list[BarPart]:
    """Return the slider of the tool in hand: the tolerance of colours, or the width of rough paint."""
    settings, name = editor.session.selecting, editor.tool.name

    def draw_tolerance(width_em: float) -> None:
        held = bar_slider("Tolerance", settings.tolerance, 0, 255, width_em=width_em)
        if held.value is not None:
            set_selecting(editor, tolerance=round(held.value))

    def draw_width(width_em: float) -> None:
        held = bar_slider(
            "Width", editor.session.brush.diameter_px, 3, 1000, unit="px", logarithmic=True, width_em=width_em
        )
        if held.value is not None:
            editor.show(brush=resize(editor.session.brush, round(held.value)))

    if name in ("wand", "colour-range"):
        extent = bar_slider_width("Tolerance", "", width_em=track_em) + em(0.8)
        return [BarPart(extent, lambda: draw_tolerance(track_em), lambda: draw_tolerance(MENU_TRACK_EM))]
    if name == "object" and settings.by_stroke:
        extent = bar_slider_width("Width", "px", width_em=track_em) + em(0.8)
        return [BarPart(extent, lambda: draw_width(track_em), lambda: draw_width(MENU_TRACK_EM))]
    return []
