"""The tools of the mode, down the left side."""

from imgui_bundle import ImVec2, imgui

from app.actions.table import ActionTable
from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.pointer_keys import word
from app.ui.widgets import theme
from app.ui.widgets.controls import disabled, end_popup, icon_button
from app.ui.widgets.overflow import BUTTON_EM, BarPart, count_fitting, draw_menu, draw_parts, extent
from app.ui.widgets.theme import color, em, icon

WIDTH_EM = 3.0
SIDES_EM = (2.3, 2.0, 1.7)
"""Side of a button; the less room, the smaller."""
GAP_EM, TOP_EM = 0.6, 0.7
"""Room between buttons, and over the first."""
HOLD_S = 0.35
"""A button that stands for several tools lists them when it is held so long."""
TWICE = {"hand": "view.fit", "zoom": "view.actual"}
"""What a double click on a tool's button does, as in other programs."""


def draw_toolbar(editor: Editor, table: ActionTable) -> None:
    """Draw a button for every tool that the mode has; where the bar is short, smaller ones, the last in a menu."""
    of_mode = [tool for tool in editor.tools.values() if editor.session.mode in tool.modes]
    last = editor.tools.get(editor.session.select_tool)
    usable = [tool for tool in of_mode if tool.group and tool.can_act(editor)]
    shown = last if last in usable or last is editor.tool else next(iter(usable), None)
    tools = [tool for tool in of_mode if not tool.group or tool is shown]
    room = imgui.get_window_height() - em(TOP_EM)
    for side_em in SIDES_EM:
        parts = [_part(editor, table, tool, side_em) for tool in tools]
        if extent(parts) <= room:
            break
    count = count_fitting(parts, room)
    draw_parts(parts[:count], em(WIDTH_EM - side_em) / 2, em(TOP_EM), down=True)
    if count < len(parts):
        below = em(TOP_EM) + extent(parts[:count])
        draw_menu("More tools", parts[count:], em(WIDTH_EM - BUTTON_EM) / 2, below)


def _part(editor: Editor, table: ActionTable, tool: Tool, side_em: float) -> BarPart:
    on, chord = editor.tool.name == tool.name, table.chord_of_tool(tool.name)
    twice = table.by_name.get(TWICE.get(tool.name, ""))

    def draw() -> None:
        hint = f"{tool.label}\n{word(tool.hint, tool.name, editor.preferences.pointer_keys)}"
        if tool.group:
            hint += "\nHold, or press the right button, for the others"
        if twice is not None:
            hint += f"\nDouble click: {twice.label}"
        with disabled(not on and not tool.can_act(editor)):
            pressed = icon_button(tool.label, tool.icon, on=on, hint=hint, key=chord, size_em=side_em)
        if pressed:
            editor.choose_tool(tool.name)
        if twice is not None and imgui.is_item_hovered() and imgui.is_mouse_double_clicked(0):
            twice.try_run(editor)
        if tool.group:
            _draw_group(editor, table, tool, on=on)

    def draw_row() -> None:
        if imgui.internal.menu_item_ex(tool.label, icon(tool.icon), chord, on, on or tool.can_act(editor)):
            editor.choose_tool(tool.name)

    return BarPart(em(side_em + GAP_EM), draw, draw_row)


def _draw_group(editor: Editor, table: ActionTable, shown: Tool, *, on: bool) -> None:
    """Mark the button that was drawn last as one of several tools, and list them where they are asked for."""
    low, side = imgui.get_item_rect_max(), em(0.35)
    corner = ImVec2(low.x - em(0.15), low.y - em(0.15))
    imgui.get_window_draw_list().add_triangle_filled(
        ImVec2(corner.x - side, corner.y),
        corner,
        ImVec2(corner.x, corner.y - side),
        color(theme.ON_ACCENT if on else theme.FAINT),
    )
    held = imgui.is_item_active() and imgui.get_io().mouse_down_duration[0] > HOLD_S
    if held or imgui.is_item_clicked(imgui.MouseButton_.right):
        imgui.open_popup(shown.group)
    if not imgui.begin_popup(shown.group):
        return
    for tool in editor.tools.values():
        if tool.group != shown.group or editor.session.mode not in tool.modes:
            continue
        chord = table.chord_of_tool(tool.name)
        label, enabled = f"{tool.label}###of group {tool.name}", tool.can_act(editor)
        if imgui.internal.menu_item_ex(label, icon(tool.icon), chord, tool is shown, enabled):
            editor.choose_tool(tool.name)
    end_popup()
