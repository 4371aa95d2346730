"""The sheet of keys: every key at a glance, whose keys they are, and a press on one sets another."""

from collections.abc import Sequence
from typing import TypeAlias

from imgui_bundle import ImVec2, imgui

from app.actions import Action, chord_of
from app.actions.keys import LABELS, with_own
from app.actions.table import ActionTable
from app.editor.editor import Editor
from app.model.events import Key, Modifiers
from app.model.pointer_keys import PAN, POINTER_KEYS, PREFIX, chord_of_modifiers, with_own_pointer
from app.ui.canvas.input import KEYS, modifiers
from app.ui.dialogs.modal import within, within_height
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, faint, heading, label, segments, shorten, tip
from app.ui.widgets.theme import em

Row: TypeAlias = tuple[str, str, str]
"""Key, meaning and the name of the action; empty for keys that stay as they are."""
Group: TypeAlias = tuple[str, Sequence[Row]]

MOST_COLUMNS, COLUMN_EM, KEY_EM = 3, 22.0, 7.5
"""How many columns of keys there are where there is room, and how wide they and their keys are."""
HEIGHT_EM, AROUND_EM = 60.0, 12.0
"""Height of the list, and of what stands around it."""
POINTER: tuple[Row, ...] = (
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
)
POINTER_GROUPS = {
    "select": "Selecting, held",
    "brush": "Brush, held",
    "points": "Points, held",
    "zoom": "Magnifier, held",
    "texture": "Texture, held",
}
"""What stands over the modifiers of each group of tools."""


class KeysSheet:
    """Draws the sheet's inside."""

    def __init__(self, editor: Editor, table: ActionTable) -> None:
        self._editor = editor
        self._table = table
        self._asked = ""
        """Name of the action, or of what the pointer does, whose key is to be pressed."""
        self._held = Modifiers()
        """The modifiers that were held since then."""

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
        if imgui.begin_table("keys", count, imgui.TableFlags_.sizing_stretch_same):
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
            what = "Press and let go" if self._takes_modifiers else "Press"
            name = self._meanings()[self._asked]
            faint(f"{what} the key for “{name}”; Backspace takes its key away, Esc leaves it.")
        else:
            faint("Press a key in the list to set another one.")

    @property
    def _takes_modifiers(self) -> bool:
        """Whether modifiers are asked for, and not a key."""
        return self._asked.startswith(PREFIX) and self._asked != PAN

    def _meanings(self) -> dict[str, str]:
        """Return what each key is for, by the names of actions and of what the pointer does."""
        of_pointer = {key.name: key.meaning for key in POINTER_KEYS} | {PAN: "Move the view"}
        return of_pointer | {name: action.label for name, action in self._table.by_name.items()}

    def _take_key(self) -> None:
        """Give what is asked for the key that is pressed; Escape leaves it, Backspace takes its key.

        Modifiers are taken when they are let go.
        """
        pressed = next((name for code, name in KEYS.items() if imgui.is_key_pressed(code, False)), None)
        if not self._asked:
            return
        now = modifiers()
        if self._takes_modifiers and pressed not in ("escape", "backspace"):
            held = self._held
            self._held = Modifiers(held.shift or now.shift, held.ctrl or now.ctrl, held.alt or now.alt)
            if now == Modifiers() and held != now:
                self._give(chord_of_modifiers(held))
        elif pressed == "escape":
            self._asked = ""
        elif pressed is not None:
            self._give("" if pressed == "backspace" else chord_of(Key(pressed, now)))

    def _give(self, chord: str) -> None:
        """Give what is asked for a key; empty for none."""
        preferences, modified = self._editor.preferences, self._takes_modifiers
        asked, self._asked, self._held = self._asked, "", Modifiers()
        if modified:
            keys = with_own_pointer(preferences.keys, preferences.key_preset, asked, chord)
        else:
            keys = with_own(preferences.keys, asked, chord)
        self._editor.prefer(preferences.changed(keys=keys))

    def _groups(self) -> list[Group]:
        """Return the keys: those of the pointer, then menu by menu, then the tools'."""
        groups: list[Group] = self._pointer_groups()
        actions = self._table.actions
        for menu in dict.fromkeys(action.menu for action in actions):
            rows = [_row(action) for action in actions if action.menu == menu and action.chord]
            if rows and menu != "Tools":
                groups.append((menu.replace("/", " › "), rows))
        return groups + self._tool_groups()

    def _pointer_groups(self) -> list[Group]:
        """Return what the pointer does, and what is held for it with which tools."""
        chords = self._editor.preferences.pointer_keys
        pan = (f"{chords[PAN]}-drag" if chords[PAN] else "", "Move the view; middle button too", PAN)
        groups: list[Group] = [("Pointer", (pan, *POINTER)), ("Brush", BRUSH)]
        for group, title in POINTER_GROUPS.items():
            of_group = [key for key in POINTER_KEYS if key.group == PREFIX + group]
            rows = [(chords[k.name] and chords[k.name] + k.how, k.meaning, k.name) for k in of_group]
            groups.append((title, rows))
        return groups

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
                    room, text = em(KEY_EM - 0.5), "…" if asked else key or "–"
                    shown = "\n".join(shorten(line, room) for line in text.split("\n"))
                    flags = imgui.SelectableFlags_.no_auto_close_popups
                    if imgui.selectable(f"{shown}##{name}", asked, flags, ImVec2(room, 0))[0]:
                        self._asked, self._held = name, Modifiers()
                    tip("Press to set another key" if shown == text else f"{text}: press to set another key")
                else:
                    imgui.text(key)
            imgui.same_line()
            imgui.set_cursor_pos_x(left + em(KEY_EM))
            imgui.text_wrapped(meaning)


def _row(action: Action) -> Row:
    """Return every key of an action, one to a line, what it does and its name."""
    return ",\n".join(chord for chord in (action.chord, *action.more_chords) if chord), action.label, action.name


def balance(groups: Sequence[Group], count: int) -> list[list[Group]]:
    """Deal the groups to `count` columns, each to the shortest, and return the columns."""
    columns: list[list[Group]] = [[] for _ in range(count)]
    for group in groups:
        min(columns, key=lambda column: sum(len(rows) + 2 for _, rows in column)).append(group)
    return columns
