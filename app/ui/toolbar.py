"""The tools of the mode, down the left side."""

from imgui_bundle import ImVec2, imgui

from app.editor import Editor
from app.ui.controls import icon_button
from app.ui.theme import em

WIDTH_EM = 3.0


def draw_toolbar(editor: Editor) -> None:
    """Draw a button for every tool that the mode has."""
    imgui.dummy(ImVec2(0, em(0.1)))
    for tool in editor.tools.values():
        if editor.session.mode not in tool.modes:
            continue
        imgui.set_cursor_pos_x((em(WIDTH_EM) - em(2.3)) / 2)
        on = editor.tool.name == tool.name
        hint = f"{tool.label}\n{tool.hint}"
        if icon_button(tool.label, tool.icon, on=on, hint=hint, key=tool.key.upper(), size_em=2.3):
            editor.choose_tool(tool.name)
        imgui.dummy(ImVec2(0, em(0.05)))
