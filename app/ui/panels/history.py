"""The undo history as a list: press an entry to go there."""

from imgui_bundle import imgui

from app.editor.editor import Editor
from app.ui.widgets import theme
from app.ui.widgets.controls import colors
from app.ui.widgets.theme import icon


class HistoryPanel:
    """Lists what was done, the newest last."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._seen: tuple[object, int] | None = None
        """The history and its present step when the list was last scrolled."""

    def draw(self) -> None:
        """Draw the entries."""
        history = self._editor.history
        for number, entry in enumerate(history.labels):
            done = number <= history.index
            with colors(text=theme.TEXT if done else theme.DISABLED):
                glyph = icon("folder-open" if number == 0 else "circle" if number == history.index else "check")
                if imgui.selectable(f"{glyph}   {entry}##{number}", number == history.index)[0]:
                    self._editor.go_to(number)
            if number == history.index and self._seen != (history, number):
                self._seen = history, number
                imgui.set_scroll_here_y(0.5)
