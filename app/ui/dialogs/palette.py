"""The command palette: type a few letters of an action's name and press Enter."""

from collections.abc import Sequence

from imgui_bundle import ImVec2, imgui

from app.actions import Action
from app.actions.file import recent_actions
from app.editor.editor import Editor
from app.ui.dialogs.modal import within, within_height
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, shorten
from app.ui.widgets.theme import em, icon

NAME = "##palette"
MOST_ROWS, ROW_EM = 12, 1.9
"""How many actions are shown at most, and the height of each with the gap after it."""
MENU_AT, KEY_AT = 0.46, 0.7
"""Where in a row the menu and the key stand, as shares of its width."""


def score(query: str, text: str) -> float | None:
    """Return how well `text` answers `query`, higher is better; None where letters are missing or out of order."""
    text, query = text.lower(), query.lower().strip()
    at, total, previous = -1, 0.0, -2
    for letter in query:
        at = text.find(letter, at + 1)
        if at < 0:
            return None
        starts_word = at == 0 or not text[at - 1].isalnum()
        total += 3.0 if starts_word else 1.5 if at == previous + 1 else 0.0
        total -= 0.01 * at
        previous = at
    return total + (5.0 if query and query in text else 0.0)


def matches(query: str, actions: Sequence[Action]) -> list[Action]:
    """Return the actions that answer `query`, the best first."""
    found = []
    for action in actions:
        named, placed = score(query, action.label), score(query, f"{action.menu} {action.label}")
        if placed is not None:
            found.append((placed if named is None else max(named + 1, placed), action))
    return [action for _, action in sorted(found, key=lambda row: -row[0])]


class CommandPalette:
    """A list of actions under a line to type into."""

    def __init__(self, editor: Editor, actions: Sequence[Action]) -> None:
        self._editor = editor
        self._actions = actions
        self._query = ""
        self._chosen = 0
        self._opens = False

    def open(self) -> None:
        """Show the palette from the next frame on."""
        self._opens, self._query, self._chosen = True, "", 0

    def draw(self) -> None:
        """Draw the palette while it is open, and run what is chosen."""
        if self._opens:
            imgui.open_popup(NAME)
        viewport = imgui.get_main_viewport()
        imgui.set_next_window_pos(
            ImVec2(viewport.get_center().x, viewport.work_pos.y + em(4)), imgui.Cond_.always, ImVec2(0.5, 0)
        )
        imgui.set_next_window_size(ImVec2(within(36), 0))
        if not imgui.begin_popup(NAME):
            return
        if self._opens:
            imgui.set_keyboard_focus_here()
            self._opens = False
        chosen = self._draw_inside()
        if chosen is not None or imgui.is_key_pressed(imgui.Key.escape):
            imgui.close_current_popup()
        imgui.end_popup()
        if chosen is not None:
            chosen.try_run(self._editor)

    def found(self) -> list[Action]:
        """Return the actions that answer what is typed, those that cannot be done now last."""
        found = matches(self._query, (*self._actions, *recent_actions(self._editor)))
        return sorted(found, key=lambda action: not action.enabled(self._editor))

    def _draw_inside(self) -> Action | None:
        """Draw line and list; return the action to run."""
        imgui.set_next_item_width(-1)
        imgui.push_style_var(imgui.StyleVar_.frame_padding, ImVec2(em(0.6), em(0.5)))
        typed, self._query = imgui.input_text_with_hint("##query", "What do you want to do?", self._query)
        imgui.pop_style_var()
        found = self.found()
        if typed:
            self._chosen = 0
        self._move(len(found))
        pressed = None
        rows = min(max(int(within_height(MOST_ROWS * ROW_EM, 9) / em(ROW_EM)), 3), MOST_ROWS)
        first = max(0, self._chosen - rows + 1)
        for number, action in list(enumerate(found))[first : first + rows]:
            if self._draw_row(action, on=number == self._chosen):
                pressed = action
        if not found:
            imgui.text_disabled("Nothing is called that")
        if found and (imgui.is_key_pressed(imgui.Key.enter) or imgui.is_key_pressed(imgui.Key.keypad_enter)):
            return found[self._chosen] if found[self._chosen].enabled(self._editor) else None
        return pressed

    def _move(self, count: int) -> None:
        """Follow the arrow keys."""
        down = imgui.is_key_pressed(imgui.Key.down_arrow) - imgui.is_key_pressed(imgui.Key.up_arrow)
        self._chosen = (self._chosen + down) % count if count else 0

    def _draw_row(self, action: Action, *, on: bool) -> bool:
        """Draw one action; return whether it was pressed."""
        left = imgui.get_cursor_pos_x()
        imgui.begin_disabled(not action.enabled(self._editor))
        pressed = imgui.selectable(f"##{action.name}", on, 0, ImVec2(0, em(1.5)))[0]
        imgui.same_line(left + em(0.3))
        imgui.text(icon(action.icon) if action.icon else "")
        imgui.same_line(left + em(2.2))
        width = imgui.get_window_width()
        imgui.text(shorten(action.label, width * MENU_AT - em(2.4)))
        imgui.same_line(left + width * MENU_AT)
        with colors(text=theme.FAINT):
            imgui.text(shorten(action.menu.replace("/", " › "), width * (KEY_AT - MENU_AT)))
        imgui.same_line(left + width * KEY_AT)
        with colors(text=theme.ACCENT):
            imgui.text(action.chord)
        imgui.end_disabled()
        return pressed
