"""Shows what the editor requests: a file to choose, a question to answer, a picture to export; one at a time."""

import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from imgui_bundle import imgui, portable_file_dialogs

from app.editor.editor import Editor
from app.files.typed_paths import is_folder
from app.model.requests import (
    AskChanged,
    AskRecover,
    AskUnsaved,
    AskWriting,
    ExportPicture,
    OpenFile,
    Panel,
    Request,
    SaveFile,
    ShowPanel,
    complete,
)
from app.ui.dialogs.export import ExportDialog
from app.ui.dialogs.file_browser import FileBrowser, home
from app.ui.dialogs.modal import modal
from app.ui.dialogs.question import question_about
from app.ui.dialogs.recover import RecoverDialog, ThumbnailOf
from app.ui.widgets.controls import faint, plain_button

_BY_KEYS = int(imgui.ConfigFlags_.nav_enable_keyboard)
"""Tab goes from button to button while a dialog is open; the window has other uses for it."""


class Dialog(Protocol):
    """Something that is drawn over the window until it is answered."""

    title: str

    def draw(self) -> bool:
        """Draw the inside; return whether it stays open."""


class Dialogs:
    """The dialog that is open, if any."""

    def __init__(self, editor: Editor, show_panel: Callable[[Panel], None], thumbnail: ThumbnailOf) -> None:
        self._editor = editor
        self._thumbnail = thumbnail
        self._show_panel = show_panel
        self._dialog: Dialog | None = None

    @property
    def title(self) -> str | None:
        """Title of the open dialog."""
        return self._dialog.title if self._dialog is not None else None

    def close(self) -> None:
        """Close the open dialog without an answer."""
        self._dialog = None

    def draw(self) -> float | None:
        """Draw the open dialog, or open the next; return seconds until it wants a frame."""
        while self._dialog is None and self._editor.requests:
            self._take(self._editor.requests.pop(0))
        flags = imgui.get_io().config_flags & ~_BY_KEYS
        imgui.get_io().config_flags = flags if self._dialog is None else flags | _BY_KEYS
        if self._dialog is None:
            return None
        self._draw_modal(self._dialog)
        return 0.1 if isinstance(self._dialog, SystemFileDialog) else None

    def _take(self, request: Request) -> None:
        if isinstance(request, ShowPanel):
            self._show_panel(request.panel)
        else:
            self._dialog = dialog_for(request, self._editor, self._thumbnail)

    def _draw_modal(self, dialog: Dialog) -> None:
        with modal(dialog.title) as shown:
            if shown and not dialog.draw():
                self._dialog = None
                imgui.close_current_popup()


def dialog_for(request: Request, editor: Editor, thumbnail: ThumbnailOf) -> Dialog:
    """Return the dialog that answers `request`; `thumbnail` gives pictures to show in it."""
    match request:
        case OpenFile() | SaveFile():
            return _file_dialog(request, editor)
        case ExportPicture():
            return ExportDialog(request, editor.map.warped if editor.session.mode == "warp" else editor.answer.warped)
        case AskUnsaved() | AskChanged() | AskWriting():
            return question_about(request)
        case AskRecover():
            return RecoverDialog(request, thumbnail)
    raise TypeError(request)


def _file_dialog(request: OpenFile | SaveFile, editor: Editor) -> Dialog:
    """Return the dialog that chooses a file, the desktop's where it has one, and remembers its folder."""
    folder = _folder(editor)

    def then(path: Path) -> None:
        editor.show(folder=path.parent)
        request.then(path)

    if isinstance(request, OpenFile):
        if has_system_dialogs():
            return SystemFileDialog(request.title, request.extensions, folder, then)
        return BrowserDialog(request.title, FileBrowser(request.extensions, folder), then)
    suggested = request.suggested
    if editor.project_path is None and editor.session.folder is not None:
        suggested = folder / suggested.name
    if has_system_dialogs():
        return SystemFileDialog(request.title, request.extensions, suggested, then, saves=True)
    browser = FileBrowser(request.extensions, suggested.parent, name=suggested.name)
    return BrowserDialog(request.title, browser, then)


def _folder(editor: Editor) -> Path:
    """Return the folder that file dialogs open on: that of the last one, or of the document."""
    path = editor.project_path or editor.source_path
    last = editor.session.folder
    return last if last is not None and is_folder(last) else path.parent if path is not None else home()


def has_system_dialogs() -> bool:
    """Return whether the desktop's own file dialogs can be shown."""
    if sys.platform in ("win32", "darwin"):
        return True
    return any(shutil.which(program) for program in ("zenity", "kdialog", "matedialog", "qarma"))


class BrowserDialog:
    """The file browser of our own as a dialog."""

    def __init__(self, title: str, browser: FileBrowser, then: Callable[[Path], None]) -> None:
        self.title = title
        self._browser = browser
        self._then = then

    def draw(self) -> bool:
        """Draw the browser."""
        answer = self._browser.draw()
        if isinstance(answer, Path):
            self._then(answer)
            return False
        return answer


class SystemFileDialog:
    """A file dialog of the desktop, which runs beside the window; the window waits for it."""

    def __init__(
        self,
        title: str,
        extensions: tuple[str, ...],
        start: Path,
        then: Callable[[Path], None],
        *,
        saves: bool = False,
    ) -> None:
        self.title = title
        self._extensions, self._saves = extensions, saves
        self._then = then
        self._dialog = self._shown(start)

    def _shown(self, start: Path) -> portable_file_dialogs.save_file | portable_file_dialogs.open_file:
        """Show the desktop's dialog on `start`."""
        patterns = " ".join(f"*.{extension}" for extension in self._extensions)
        kind = portable_file_dialogs.save_file if self._saves else portable_file_dialogs.open_file
        return kind(self.title, str(start), [f"{self.title} ({patterns})", patterns, "All files", "*"])

    def draw(self) -> bool:
        """Wait for the answer."""
        faint("Choose in the window that has opened.")
        if plain_button("Cancel", 7):
            self._dialog.kill()
            return False
        if not self._dialog.ready(0):
            return True
        answer = self._dialog.result()
        path = answer if isinstance(answer, str) else answer[0] if answer else ""
        return bool(path) and not self._takes(Path(path))

    def _takes(self, path: Path) -> bool:
        """Take the answer; a name that is not written out may be that of another file, which only it can ask about."""
        whole = complete(path, self._extensions) if self._saves else path
        if whole != path and whole.exists():
            self._dialog = self._shown(whole)
            return False
        self._then(whole)
        return True
