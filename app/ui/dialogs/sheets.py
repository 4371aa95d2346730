"""Sheets over the window: every key at a glance, what Weft is, and the preferences."""

from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Literal, TypeAlias

from imgui_bundle import ImVec2, imgui

from app.actions import Action
from app.editor.editor import Editor
from app.ui.dialogs.modal import modal, within
from app.ui.dialogs.preferences import PreferencesSheet
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, faint, heading, primary_button
from app.ui.widgets.theme import em

Sheet = Literal["keys", "about", "preferences"]
TITLES: dict[Sheet, str] = {"keys": "Keys", "about": "About Weft", "preferences": "Preferences"}
Group: TypeAlias = tuple[str, Sequence[tuple[str, str]]]
"""A title and its rows of key and meaning."""

MOST_COLUMNS, COLUMN_EM, KEY_EM = 3, 22.0, 7.5
"""How many columns of keys there are where there is room, and how wide they and their keys are."""

POINTER = (
    ("Space-drag", "Move the view; middle button too"),
    ("Wheel", "Zoom at the pointer"),
    ("Esc", "Cancel what is being dragged"),
    ("Enter", "End the curve that is being drawn"),
    ("Backspace", "Take its last point back"),
    ("Arrows", "Move what is selected by a pixel, with Shift by ten"),
    ("Delete", "Remove what is selected"),
)
BRUSH = (
    ("[ ]", "Smaller, larger"),
    ("Shift+[ ]", "Softer, harder"),
    ("X", "Paint or erase"),
    ("Shift-click", "A straight line from the last stroke"),
)


class Sheets:
    """The sheet that is open, if any."""

    def __init__(self, editor: Editor, actions: Sequence[Action]) -> None:
        self._editor = editor
        self._actions = actions
        self._preferences = PreferencesSheet(editor)
        self.shown: Sheet | None = None

    def draw(self) -> None:
        """Draw the sheet over the window."""
        if self.shown is None:
            return
        with modal(TITLES[self.shown]) as shown:
            if shown:
                self._draw_inside(self.shown)

    def _draw_inside(self, sheet: Sheet) -> None:
        draw = {"keys": self._draw_keys, "about": self._draw_about, "preferences": self._preferences.draw}
        draw[sheet]()
        imgui.dummy(ImVec2(0, em(0.3)))
        if primary_button("Close", 7) or imgui.is_key_pressed(imgui.Key.escape):
            self.shown = None
            imgui.close_current_popup()

    def _draw_keys(self) -> None:
        """Draw the keys in columns of about the same height."""
        room = within(MOST_COLUMNS * COLUMN_EM)
        count = max(int(room / em(COLUMN_EM)), 1)
        if imgui.begin_table("keys", count, 0, ImVec2(min(em(COLUMN_EM) * count, room), 0)):
            for column in balanced(self._groups(), count):
                imgui.table_next_column()
                for title, rows in column:
                    _draw_group(title, rows)
            imgui.end_table()

    def _groups(self) -> list[Group]:
        """Return the keys: those of the pointer, then menu by menu."""
        groups: list[Group] = [("Pointer", list(POINTER)), ("Brush", list(BRUSH))]
        for menu in dict.fromkeys(action.menu for action in self._actions):
            rows = [(_keys(action), action.label) for action in self._actions if action.menu == menu and action.chord]
            if rows and menu != "Tools":
                groups.append((menu.replace("/", " › "), rows))
        return groups + self._tool_groups()

    def _tool_groups(self) -> list[Group]:
        """Return the keys of tools: those of one mode only, mode by mode, and those of all."""
        groups: dict[str, list[tuple[str, str]]] = {}
        for tool in self._editor.tools.values():
            of_mode = f"Tools of {next(iter(tool.modes)).capitalize()}" if len(tool.modes) == 1 else "Tools"
            groups.setdefault(of_mode, []).append((tool.key.upper(), tool.label))
        return list(groups.items())

    def _draw_about(self) -> None:
        imgui.push_font(None, theme.TITLE_PX)
        imgui.text("Weft")
        imgui.pop_font()
        faint(f"Version {_version()}. Free software under the GNU General Public License, version 3 or later.")
        imgui.dummy(ImVec2(within(30), em(0.3)))
        imgui.text("Bend a picture and keep its features: warp, retexture and overlay, live.")


def _keys(action: Action) -> str:
    """Return every key of an action."""
    return ", ".join((action.chord, *action.more_chords))


def balanced(groups: Sequence[Group], count: int) -> list[list[Group]]:
    """Deal the groups to `count` columns, each to the shortest, and return the columns."""
    columns: list[list[Group]] = [[] for _ in range(count)]
    for group in groups:
        min(columns, key=lambda column: sum(len(rows) + 2 for _, rows in column)).append(group)
    return columns


def _draw_group(title: str, rows: Sequence[tuple[str, str]]) -> None:
    heading(title)
    left = imgui.get_cursor_pos_x()
    for key, name in rows:
        with colors(text=theme.ACCENT):
            imgui.text(key)
        imgui.same_line()
        imgui.set_cursor_pos_x(left + em(KEY_EM))
        imgui.text(name)


def _version() -> str:
    try:
        return version("weft")
    except PackageNotFoundError:
        return "of the source folder"
