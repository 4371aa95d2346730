"""The sheet of keys: every key at a glance, whose keys they are, and a press on one sets another."""

from collections.abc import Sequence
from typing import TypeAlias

from imgui_bundle import ImVec2, imgui

from app.actions import Action, chord_of
from app.actions.keys import LABELS, with_own
from app.actions.table import ActionTable
from app.editor.editor import Editor
from app.model.events import Key
from app.ui.canvas.input import KEYS, modifiers
from app.ui.dialogs.modal import within, within_height
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, faint, heading, label, segments, tip
from app.ui.widgets.theme import em

Row: TypeAlias = tuple[str, str, str]
"""Key, meaning and the name of the action; empty for keys that stay as they are."""
Group: TypeAlias = tuple[str, Sequence[Row]]

MOST_COLUMNS, COLUMN_EM, KEY_EM = 3, 22.0, 7.5
"""How many columns of keys there are where there is room, and how wide they and their keys are."""
HEIGHT_EM, AROUND_EM = 60.0, 12.0
"""Height of the list, and of what stands around it."""
POINTER: tuple[Row, ...] = (
    ("Space-drag", "Move the view; middle button too", ""),
    ("Wheel", "Zoom at the pointer", ""),
    ("Esc", "Cancel what is being dragged", ""),
    ("Enter", "End the curve or outline that is being drawn", ""),
    ("Backspace", "Take its last point back", ""),
    ("Arrows", "Move what is selected by a pixel, with Shift by ten", ""),
    ("Delete", "Remove what is selected", ""),
)
BRUSH: tuple[Row, ...] = (
    ("[ ]", "Smaller, larger", ""),
    ("Shift+[ ]", "Softer, harder", ""),
    ("X", "Paint or erase", ""),
    ("Shift-click", "A straight line from the last stroke", ""),
)


class KeysSheet:
    """Draws the sheet's inside."""

    def __init__(self, editor: Editor, table: ActionTable) -> None:
        self._editor = editor
        self._table = table
        self._asked = ""
        """Name of the action whose key is to be pressed."""

    @property
    def is_asking(self) -> bool:
        """Whether a key is waited for."""
        return bool(self._asked)

    @is_asking.setter
    def is_asking(self, asks: bool) -> None:
        if not asks:
            self._asked = ""

    def draw(self) -> None:
        """Draw whose keys they are and the keys in columns of about the same height."""
        room = within(MOST_COLUMNS * COLUMN_EM)
        imgui.dummy(ImVec2(room, 0))
        self._draw_preset()
        self._take_key()
        count = max(int(room / em(COLUMN_EM)), 1)
        imgui.begin_child("##list", ImVec2(room, within_height(HEIGHT_EM, AROUND_EM)))
        room = imgui.get_content_region_avail().x  # beside the scrollbar
        if imgui.begin_table("keys", count, 0, ImVec2(min(em(COLUMN_EM) * count, room), 0)):
            for column in balance(self._groups(), count):
                imgui.table_next_column()
                for title, rows in column:
                    self._draw_group(title, rows)
            imgui.end_table()
        imgui.end_child()

    def _draw_preset(self) -> None:
        preferences = self._editor.preferences
        label("Keys of", "Keys that users of other programs know")
        chosen = segments("preset", LABELS, preferences.key_preset)
        if chosen is not None:
            self._editor.prefer(preferences.changed(key_preset=chosen, keys=()))
        if self._asked:
            name = self._table.by_name[self._asked].label
            faint(f"Press the key for “{name}”; Backspace takes its key away, Esc leaves it.")
        else:
            faint("Press a key in the list to set another one.")

    def _take_key(self) -> None:
        """Give the action that is asked for the key that is pressed; Escape leaves it, Backspace takes its key."""
        pressed = next((name for code, name in KEYS.items() if imgui.is_key_pressed(code, False)), None)
        if not self._asked or pressed is None:
            return
        asked, self._asked = self._asked, ""
        if pressed != "escape":
            chord = "" if pressed == "backspace" else chord_of(Key(pressed, modifiers()))
            preferences = self._editor.preferences
            self._editor.prefer(preferences.changed(keys=with_own(preferences.keys, asked, chord)))

    def _groups(self) -> list[Group]:
        """Return the keys: those of the pointer, then menu by menu, then the tools'."""
        groups: list[Group] = [("Pointer", POINTER), ("Brush", BRUSH)]
        actions = self._table.actions
        for menu in dict.fromkeys(action.menu for action in actions):
            rows = [_row(action) for action in actions if action.menu == menu and action.chord]
            if rows and menu != "Tools":
                groups.append((menu.replace("/", " › "), rows))
        return groups + self._tool_groups()

    def _tool_groups(self) -> list[Group]:
        """Return the keys of tools: those of one mode only, mode by mode, and those of all."""
        groups: dict[str, list[Row]] = {}
        for tool in self._editor.tools.values():
            of_mode = f"Tools of {next(iter(tool.modes)).capitalize()}" if len(tool.modes) == 1 else "Tools"
            groups.setdefault(of_mode, []).append(_row(self._table.by_name[f"tool.{tool.name}"]))
        return list(groups.items())

    def _draw_group(self, title: str, rows: Sequence[Row]) -> None:
        heading(title)
        left = imgui.get_cursor_pos_x()
        for key, meaning, name in rows:
            asked = bool(name) and name == self._asked
            with colors(text=theme.TARGET if asked else theme.ACCENT):
                if name:
                    shown = f"{'…' if asked else key or '–'}##{name}"
                    if imgui.selectable(
                        shown, asked, imgui.SelectableFlags_.no_auto_close_popups, ImVec2(em(KEY_EM - 0.5), 0)
                    )[0]:
                        self._asked = name
                    tip("Press to set another key")
                else:
                    imgui.text(key)
            imgui.same_line()
            imgui.set_cursor_pos_x(left + em(KEY_EM))
            imgui.text(meaning)


def _row(action: Action) -> Row:
    """Return every key of an action, what it does and its name."""
    return ", ".join(chord for chord in (action.chord, *action.more_chords) if chord), action.label, action.name


def balance(groups: Sequence[Group], count: int) -> list[list[Group]]:
    """Deal the groups to `count` columns, each to the shortest, and return the columns."""
    columns: list[list[Group]] = [[] for _ in range(count)]
    for group in groups:
        min(columns, key=lambda column: sum(len(rows) + 2 for _, rows in column)).append(group)
    return columns
