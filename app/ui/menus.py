"""The menu bar, made from the action table, with the switch of modes in its middle."""

from collections.abc import Sequence
from typing import TypeAlias, Union

from imgui_bundle import ImVec2, imgui

from app.actions import Action
from app.actions.file import recent_actions
from app.actions.table import ActionTable
from app.editor import Editor
from app.ui import theme
from app.ui.controls import colors, tip
from app.ui.theme import em, icon

Tree: TypeAlias = dict[str, Union["Tree", Action]]
"""Menus by title and actions by name, in the order in which they stand."""


def menu_tree(actions: Sequence[Action]) -> Tree:
    """Return the menus that `Action.menu` describes, "/" between levels."""
    root: Tree = {}
    for action in actions:
        menu = root
        for title in action.menu.split("/"):
            inner = menu.setdefault(title, {})
            assert isinstance(inner, dict)
            menu = inner
        menu[action.name] = action
    return root


class MenuBar:
    """Draws the menus of an action table."""

    def __init__(self, editor: Editor, table: ActionTable) -> None:
        self._editor = editor
        self._table = table
        self._tree = menu_tree(table.actions)

    def draw(self) -> None:
        """Draw the bar."""
        self._draw_entries({title: menu for title, menu in self._tree.items() if title != "Mode"})
        self._draw_modes()

    def _draw_entries(self, entries: Tree) -> None:
        for title, entry in entries.items():
            if isinstance(entry, Action):
                self._draw_item(entry)
            elif imgui.begin_menu(title):
                self._draw_entries(entry)
                imgui.end_menu()
            if title == "file.open":
                self._draw_recent()

    def _draw_recent(self) -> None:
        """Draw the files that were opened last."""
        recent = recent_actions(self._editor)
        if imgui.begin_menu("Open recent", bool(recent)):
            self._draw_entries({action.name: action for action in recent})
            imgui.end_menu()

    def _draw_item(self, action: Action) -> None:
        if action.separated:
            imgui.separator()
        checked = action.checked is not None and action.checked(self._editor)
        glyph = icon(action.icon) if action.icon else ""
        enabled = action.enabled(self._editor)
        if imgui.internal.menu_item_ex(f"{action.label}###{action.name}", glyph, action.chord, checked, enabled):
            action.run(self._editor)
        tip(action.tooltip)

    def _draw_modes(self) -> None:
        """Draw one button for each mode, in the middle of the bar."""
        actions = [action for action in self._table.actions if action.name.startswith("mode.")]
        width = em(6.4)
        imgui.same_line(max(imgui.get_window_width() / 2 - len(actions) / 2 * width, imgui.get_cursor_pos_x()))
        imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(1, 0))
        imgui.push_style_var(imgui.StyleVar_.frame_rounding, 0)
        for action in actions:
            self._draw_mode(action, width)
            imgui.same_line()
        imgui.pop_style_var(2)

    def _draw_mode(self, action: Action, width: float) -> None:
        on = action.checked is not None and action.checked(self._editor)
        with colors(
            button=theme.ACCENT if on else theme.RAISED,
            button_hovered=theme.ACCENT if on else theme.BUTTON_HOVERED,
            text=theme.ON_ACCENT if on else theme.TEXT,
        ):
            imgui.begin_disabled(not action.enabled(self._editor))
            if imgui.button(f"{action.label}##{action.name}", ImVec2(width, imgui.get_frame_height())):
                action.run(self._editor)
            imgui.end_disabled()
        tip(action.tooltip, action.chord)
