"""The menu bar, made from the action table, with the switch of modes in its middle."""

from collections.abc import Sequence
from typing import TypeAlias, Union

from imgui_bundle import ImVec2, imgui

from app.actions import Action
from app.actions.file import recent_actions
from app.actions.table import ActionTable
from app.editor.editor import Editor
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, tip
from app.ui.widgets.theme import em, icon

MODE_EM = 6.4
"""Width of a mode's button where there is room."""
MORE = "ellipsis"

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


def draw_item(editor: Editor, action: Action) -> None:
    """Draw an action as an entry of a menu."""
    checked = action.checked is not None and action.checked(editor)
    glyph = icon(action.icon) if action.icon else ""
    enabled = action.enabled(editor)
    if imgui.internal.menu_item_ex(f"{action.label}###{action.name}", glyph, action.chord, checked, enabled):
        action.try_run(editor)
    tip(action.tooltip)


def _title_width(title: str) -> float:
    """Return how much of the bar a menu's title takes, in screen pixels."""
    return imgui.calc_text_size(title, hide_text_after_double_hash=True).x + 2 * imgui.get_style().item_spacing.x


def _fitting(titles: Sequence[str], room: float) -> int:
    """Return how many menus, the first ones, have their titles in the bar; the rest is left to a last one."""
    if sum(map(_title_width, titles)) <= room:
        return len(titles)
    left, count = room - _title_width(icon(MORE)), 0
    while left >= _title_width(titles[count]):
        left -= _title_width(titles[count])
        count += 1
    return count


class MenuBar:
    """Draws the menus of an action table."""

    def __init__(self, editor: Editor, table: ActionTable) -> None:
        self._editor = editor
        self._table = table
        self._actions: list[Action] = []
        """Those that the menus were made of."""

    def draw(self) -> None:
        """Draw the bar: where it is short, first the buttons of the modes shrink, then menus go into a last one."""
        if self._actions != self._table.actions:
            self._actions = list(self._table.actions)
            self._tree = menu_tree(self._actions)
            self._modes = [action for action in self._actions if action.menu == "Mode"]
        room = imgui.get_window_width() - imgui.get_cursor_pos_x()
        menus = {title: menu for title, menu in self._tree.items() if title != "Mode"}
        mode_width = em(MODE_EM)
        if sum(map(_title_width, menus)) + len(self._modes) * mode_width > room:
            mode_width = max(imgui.calc_text_size(action.label).x for action in self._modes) + em(1)
        if len(self._modes) * mode_width > room / 2:
            menus, mode_width = {"Mode": self._tree["Mode"], **menus}, 0.0
        count = _fitting(list(menus), room - len(self._modes) * mode_width)
        self._draw_entries(dict(list(menus.items())[:count]))
        if count < len(menus):
            self._draw_entries({f"{icon(MORE)}###More menus": dict(list(menus.items())[count:])})
        if mode_width:
            self._draw_modes(mode_width)

    def _draw_entries(self, entries: Tree) -> None:
        for title, entry in entries.items():
            if isinstance(entry, Action):
                if entry.separated:
                    imgui.separator()
                draw_item(self._editor, entry)
            elif imgui.begin_menu(title):
                self._draw_entries(entry)
                if imgui.is_key_pressed(imgui.Key.escape):
                    imgui.close_current_popup()
                imgui.end_menu()
            if title == "file.open":
                self._draw_recent()

    def _draw_recent(self) -> None:
        """Draw the files that were opened last."""
        recent = recent_actions(self._editor)
        if imgui.begin_menu("Open recent", bool(recent)):
            self._draw_entries({action.name: action for action in recent})
            imgui.end_menu()

    def _draw_modes(self, width: float) -> None:
        """Draw one button for each mode, `width` screen pixels wide, in the middle of the bar where there is room."""
        room, total = imgui.get_window_width(), len(self._modes) * width
        imgui.set_cursor_pos_x(min(max((room - total) / 2, imgui.get_cursor_pos_x()), room - total))
        imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(1, 0))
        imgui.push_style_var(imgui.StyleVar_.frame_rounding, 0)
        for action in self._modes:
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
