"""A file browser inside the window, for machines that have no program for system dialogs."""

import contextlib
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import platformdirs
from imgui_bundle import ImVec2, imgui

from app.files.typed_paths import is_file, is_folder, is_there, resolve_name
from app.model.requests import complete
from app.ui.dialogs.modal import within, within_height
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, icon_button, plain_button, primary_button, tip
from app.ui.widgets.fallback_fonts import writable
from app.ui.widgets.theme import em, icon
from core.arrays import InputError
from core.files.text import begin_sentence, legible

PLACES_EM = 10.0
"""Width of the list of places to start from."""
DETAILS_FROM_EM = 24.0
"""The list of files says size and date from this width on."""


@dataclass(frozen=True)
class FileRow:
    """An entry of a folder."""

    path: Path
    is_folder: bool
    size: int
    modified: float


class FileBrowser:
    """Choose a file that exists, or a name to write to; `draw` it inside a popup."""

    def __init__(self, extensions: tuple[str, ...], folder: Path, *, name: str | None = None) -> None:
        self._extensions = extensions
        self._saves = name is not None
        self._name = name or ""
        self._asks_overwrite: Path | None = None
        self._fault = ""
        self._picked: Path | None = None
        """The file that was picked from the list; its name may hold bytes that cannot be typed."""
        self._takes_keys = True
        self._selects_stem = self._saves
        self._ending = Path(self._name).suffix
        self.folder = folder
        self._items: tuple[FileRow, ...] = ()
        self._sought = ""
        """What was typed last."""
        self._is_stepping = False
        """Whether an arrow key has just put another name into the line."""
        self._listed: list[FileRow] = []
        """The entries of the folder that are listed."""
        self.enter(folder if is_folder(folder) else home())

    def enter(self, folder: Path) -> None:
        """Show another folder."""
        try:
            folder = folder.absolute()
            self._items = list_folder(folder, self._extensions)
        except (OSError, ValueError) as fault:
            self._fault = f"{folder}: {getattr(fault, 'strerror', None) or fault}"
            return
        self.folder, self._fault, self._asks_overwrite = folder, "", None
        self._seek("")

    def _seek(self, typed: str) -> None:
        """List the entries whose names hold what is typed, where a file is to be opened; else all."""
        self._sought = typed
        sought = "" if self._saves or "/" in typed else typed.strip().lower()
        self._listed = [item for item in self._items if sought in item.path.name.lower()]

    def draw(self) -> Path | bool:
        """Draw the browser; return the chosen file, False when it was closed, True while it is open."""
        self._draw_trail()
        height = within_height(22, 11.5)
        imgui.begin_child("places", ImVec2(em(PLACES_EM), height))
        for place, glyph, path in places():
            if imgui.selectable(f"{icon(glyph)}   {place}", path == self.folder)[0]:
                self.enter(path)
        imgui.end_child()
        imgui.same_line()
        chosen = self._draw_items(ImVec2(within(PLACES_EM + 36) - em(PLACES_EM), height))
        return self._draw_foot(chosen)

    def _draw_trail(self) -> None:
        """Draw the folders above, each a button."""
        if icon_button("Up", "arrow-up", hint="To the folder above", size_em=1.7):
            self.enter(self.folder.parent)
        parts = [self.folder, *self.folder.parents][::-1][-5:]
        while len(parts) > 1 and sum(map(_width, parts)) > within(PLACES_EM + 36) - em(3):
            parts.pop(0)
        for part in parts:
            imgui.same_line(0, em(0.3))
            with colors(button=theme.RAISED):
                if imgui.button(f"{writable(_called(part))}##{legible(str(part))}"):
                    self.enter(part)
            imgui.same_line(0, em(0.3))
            with colors(text=theme.DISABLED):
                imgui.text(icon("angle-right"))
        imgui.new_line()

    def _draw_items(self, size: ImVec2) -> Path | None:
        """Draw the folder's entries; return the file that was double-clicked."""
        chosen: Path | None = None
        entered: Path | None = None
        flags = imgui.TableFlags_.scroll_y | imgui.TableFlags_.row_bg | imgui.TableFlags_.borders_outer
        is_wide = size.x > em(DETAILS_FROM_EM)
        if imgui.begin_table("files", 3 if is_wide else 1, flags, size):
            imgui.table_setup_column("Name", imgui.TableColumnFlags_.width_stretch)
            if is_wide:
                imgui.table_setup_column("Size", imgui.TableColumnFlags_.width_fixed, em(4.5))
                imgui.table_setup_column("Changed", imgui.TableColumnFlags_.width_fixed, em(7))
            for number in self._rows_in_sight():
                item = self._listed[number]
                imgui.table_next_row()
                imgui.table_next_column()
                if self._draw_item(item, number):
                    chosen, entered = (None, item.path) if item.is_folder else (item.path, None)
                if is_wide:
                    _draw_details(item)
            imgui.end_table()
        if entered is not None:
            self.enter(entered)
        return chosen

    def _rows_in_sight(self) -> Iterator[int]:
        """Yield the numbers of the listed entries that are in sight, and of the one that an arrow key went to."""
        clipper = imgui.ListClipper()
        clipper.begin(len(self._listed))
        if self._is_stepping:
            found = (n for n, item in enumerate(self._listed) if legible(item.path.name) == self._name)
            clipper.include_item_by_index(next(found, 0))
        while clipper.step():
            yield from range(clipper.display_start, clipper.display_end)

    def _draw_item(self, item: FileRow, number: int) -> bool:
        """Draw one entry; return whether it was double-clicked."""
        glyph = "folder" if item.is_folder else "diagram-project" if item.path.suffix == ".weft" else "image"
        flags = imgui.SelectableFlags_.span_all_columns | imgui.SelectableFlags_.allow_double_click
        flags |= imgui.SelectableFlags_.no_auto_close_popups
        name = legible(item.path.name)
        pressed = imgui.selectable(f"{icon(glyph)}   {writable(name)}##{number}", name == self._name, flags)[0]
        if self._is_stepping and name == self._name:
            imgui.set_scroll_here_y()
            self._is_stepping = False
        if pressed and not item.is_folder:
            self._name, self._picked, self._asks_overwrite = name, item.path, None
        return pressed and imgui.is_mouse_double_clicked(0)

    def _draw_foot(self, chosen: Path | None) -> Path | bool:
        """Draw name, buttons and what is wrong."""
        imgui.set_next_item_width(within(46) - 2 * em(7) - em(2))
        if self._takes_keys:
            imgui.set_keyboard_focus_here()
            self._takes_keys = False
        flags = imgui.InputTextFlags_.enter_returns_true | imgui.InputTextFlags_.callback_always
        flags |= imgui.InputTextFlags_.callback_history
        entered, name = imgui.input_text("##name", self._name, flags, self._edit_name)
        if name != self._name:
            self._name = name
            if not self._is_stepping:
                self._seek(name)
        tip("Name of the file; a whole path will do. Up and down go through the list")
        imgui.same_line(0, em(1))
        verb = "Replace" if self._asks_overwrite else "Save" if self._saves else "Open"
        pressed = primary_button(verb, 7) or entered or chosen is not None
        imgui.same_line()
        closed = plain_button("Cancel", 7) or imgui.is_key_pressed(imgui.Key.escape)
        with colors(text=theme.FAULT):
            imgui.text(legible(self._fault))
        if closed:
            return False
        if not pressed:
            return True
        self._takes_keys = True
        return self.accepted(chosen)

    def _edit_name(self, data: imgui.InputTextCallbackData) -> int:
        """Select the proposed name without its ending once it can be typed over; let arrow keys go through the list."""
        if data.event_flag == imgui.InputTextFlags_.callback_history:
            self._step(data, 1 if data.event_key == imgui.Key.down_arrow else -1)
        elif self._selects_stem:
            data.set_selection(0, len(Path(self._name).stem.encode()))
            self._selects_stem = False
        return 0

    def _step(self, data: imgui.InputTextCallbackData, step: int) -> None:
        """Put the name of the entry after, or before, that of the line into it; of the first or last if none."""
        names = [legible(item.path.name) for item in self._listed]
        if not names:
            return
        at = names.index(self._name) + step if self._name in names else min(step, 0)
        self._picked = self._listed[at % len(names)].path
        data.delete_chars(0, data.buf_text_len)
        data.insert_chars(0, names[at % len(names)])
        data.select_all()
        self._is_stepping, self._asks_overwrite = True, None

    def accepted(self, chosen: Path | None) -> Path | bool:
        """Return the file to take, True where something is to be mended first; None stands for the typed name."""
        if not self._name.strip() and chosen is None:
            self._fault = "Type a name, or choose a file"
            return True
        try:
            path = chosen or self._typed()
        except InputError as fault:
            self._fault = begin_sentence(str(fault))
            return True
        if is_folder(path) or not path.name:
            self.enter(path)
            self._name = self._name if self._saves else ""
            return True
        if not self._saves:
            self._fault = "" if is_file(path) else f"{path.name}: no such file here"
            return path if is_file(path) else True
        path = complete(path, self._extensions)
        if not is_folder(path.parent):
            self._fault = f"{path.parent}: no such folder"
            return True
        if is_there(path) and self._asks_overwrite != path:
            self._asks_overwrite, self._fault = path, f"{path.name} exists already"
            return True
        return path

    def _typed(self) -> Path:
        """Return the file whose name stands in the line."""
        picked = self._picked
        if picked is not None and picked.parent == self.folder and legible(picked.name) == self._name:
            return picked
        # The proposed ending stays where a name with another one is typed, or pasted, in the place of the stem.
        stem = self._name.removesuffix(self._ending)
        is_whole = Path(stem).suffix.lower().lstrip(".") in self._extensions
        path = resolve_name(self.folder, stem if is_whole else self._name)
        is_only_one = not self._saves and self._name == self._sought and len(self._listed) == 1
        return self._listed[0].path if is_only_one and not is_there(path) else path


def _draw_details(item: FileRow) -> None:
    """Write size and date in the columns after the name."""
    with colors(text=theme.FAINT):
        imgui.table_next_column()
        imgui.text("" if item.is_folder else readable(item.size))
        imgui.table_next_column()
        imgui.text(format_date(item.modified))


def format_date(modified: float, *, with_time: bool = False) -> str:
    """Return a time in seconds as a date; nothing for one that no calendar has."""
    try:
        return time.strftime("%d %b %Y, %H:%M" if with_time else "%d %b %Y", time.localtime(modified))
    except (OverflowError, ValueError, OSError):
        return ""


def _called(folder: Path) -> str:
    """Return what a folder is called in the line of folders."""
    return legible(folder.name or folder.anchor)


def _width(folder: Path) -> float:
    """Return how wide a folder's button is with the arrow behind it, in screen pixels."""
    return imgui.calc_text_size(_called(folder)).x + 2 * imgui.get_style().frame_padding.x + em(1.4)


def places() -> list[tuple[str, str, Path]]:
    """Return name, icon and path of the folders one starts from."""
    named = (
        ("Home", "house", home),
        ("Pictures", "image", lambda: Path(platformdirs.user_pictures_dir())),
        ("Documents", "file", lambda: Path(platformdirs.user_documents_dir())),
        ("Downloads", "download", lambda: Path(platformdirs.user_downloads_dir())),
        ("Desktop", "desktop", lambda: Path(platformdirs.user_desktop_dir())),
        ("Here", "location-dot", Path.cwd),
        ("Computer", "hard-drive", lambda: Path(home().anchor)),
    )
    found = []
    for name, glyph, place in named:
        with contextlib.suppress(OSError, RuntimeError):  # the working folder may be gone, a home unknown
            found.append((name, glyph, place()))
    return [row for row in found if is_folder(row[2])]


def home() -> Path:
    """Return the user's home, the root where there is none."""
    try:
        return Path.home()
    except RuntimeError:
        return Path("/")


def list_folder(folder: Path, extensions: tuple[str, ...]) -> tuple[FileRow, ...]:
    """Return the folder's entries, folders first; hidden ones and other kinds of file are left out."""
    items = []
    with os.scandir(folder) as entries:
        for entry in entries:
            path = Path(entry.path)
            with contextlib.suppress(OSError):  # what cannot be looked at is not listed
                shown = entry.is_dir() or path.suffix.lower().lstrip(".") in extensions
                if shown and not entry.name.startswith("."):
                    stat = entry.stat()
                    items.append(FileRow(path, entry.is_dir(), stat.st_size, stat.st_mtime))
    return tuple(sorted(items, key=lambda item: (not item.is_folder, item.path.name.lower())))


def readable(size: int) -> str:
    """Return a number of bytes as one reads it."""
    value = float(size)
    for unit in ("B", "kB", "MB"):
        if value < 1000:
            return f"{value:.0f} {unit}"
        value /= 1000
    return f"{value:.1f} GB"
