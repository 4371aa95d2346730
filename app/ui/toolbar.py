"""The tools of the mode, down the left side."""

from imgui_bundle import imgui

from app.actions.table import ActionTable
from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.pointer_keys import word
from app.ui.widgets.controls import icon_button
from app.ui.widgets.overflow import BUTTON_EM, BarPart, count_fitting, draw_menu, draw_parts, extent
from app.ui.widgets.theme import em, icon

WIDTH_EM = 3.0
SIDES_EM = (2.3, 2.0, 1.7)
"""Side of a button; the less room, the smaller."""
GAP_EM, TOP_EM = 0.6, 0.7
"""Room between buttons, and over the first."""


def draw_toolbar(editor: Editor, table: ActionTable) -> None:
    """Draw a button for every tool that the mode has; where the bar is short, smaller ones, the last in a menu."""
    shown = editor.session.select_tool
    of_mode = (tool for tool in editor.tools.values() if editor.session.mode in tool.modes)
    tools = [tool for tool in of_mode if not tool.group or tool.name == shown]
    room = imgui.get_window_height() - em(TOP_EM)
    for side_em in SIDES_EM:
        parts = [_part(editor, tool, table.chord_of_tool(tool.name), side_em) for tool in tools]
        if extent(parts) <= room:
            break
    count = count_fitting(parts, room)
    draw_parts(parts[:count], em(WIDTH_EM - side_em) / 2, em(TOP_EM), down=True)
    if count < len(parts):
        below = em(TOP_EM) + extent(parts[:count])
        draw_menu("More tools", parts[count:], em(WIDTH_EM - BUTTON_EM) / 2, below)


def _part(editor: Editor, tool: Tool, chord: str, side_em: float) -> BarPart:
    on = editor.tool.name == tool.name

    def draw() -> None:
        hint = f"{tool.label}\n{word(tool.hint, tool.name, editor.preferences.pointer_keys)}"
        if icon_button(tool.label, tool.icon, on=on, hint=hint, key=chord, size_em=side_em):
            editor.choose_tool(tool.name)

    def draw_row() -> None:
        if imgui.internal.menu_item_ex(tool.label, icon(tool.icon), chord, on):
            editor.choose_tool(tool.name)

    return BarPart(em(side_em + GAP_EM), draw, draw_row)
