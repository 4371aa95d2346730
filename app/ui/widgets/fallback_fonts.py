"""Characters that the window's own font lacks, such as Chinese, Japanese and Korean ones in names of files.

They are read off what Dear ImGui could not draw; fonts of the system that have them are looked for beside the window,
and join its font in the next frame. What no font has is written by its number.
"""

import ctypes
import threading
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import numpy as np
from imgui_bundle import imgui

from app.state.system_fonts import find_fonts
from app.ui.widgets import theme

SIZES_PX = (theme.TEXT_PX, theme.SMALL_PX + 0.5)
"""Of dialogs and panels, and of the status bar."""
REPLACEMENT = 0xFFFD
ASCII = 128
"""Every font has those before."""


class FallbackFonts:
    """Fonts of the system beside the window's own, each loaded when the first character is to be shown that it has."""

    unwritable: ClassVar[dict[int, str]] = {}
    """What is written in the place of characters that no font has, as `str.translate` takes it."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._wake = wake
        self._asked: set[int] = set()
        """Characters that fonts were looked for."""
        self._loaded: set[tuple[Path, int]] = set()
        self._search: threading.Thread | None = None
        self._found: list[tuple[int, list[tuple[Path, int]]]] = []
        """What the search has found, by character."""

    def look(self) -> None:
        """Look for fonts for what could not be drawn, beside the window; once a frame, while it is drawn."""
        if self._search is not None:
            return
        missing = set().union(*(_missing(size) for size in SIZES_PX)) - self._asked
        if missing:
            self._asked |= missing
            self._search = threading.Thread(target=self._find, args=(sorted(missing),), name="fonts", daemon=True)
            self._search.start()

    def _find(self, codes: list[int]) -> None:
        self._found = [(code, find_fonts(code)) for code in codes]
        self._wake()

    def join(self) -> None:
        """Let fonts that were found join the window's own; between two frames."""
        if self._search is None or self._search.is_alive():
            return
        self._search = None
        font = imgui.get_io().fonts.fonts[0]
        for code, files in self._found:
            for file in files:
                if not font.is_glyph_in_font(code) and file not in self._loaded:
                    self._loaded.add(file)
                    _load(font, *file)
            if not font.is_glyph_in_font(code):
                FallbackFonts.unwritable[code] = f"\\u{code:04x}"


def writable(text: str) -> str:
    r"""Return a text with the numbers of those characters that no font has: "\u4e2d"."""
    return text if text.isascii() else text.translate(FallbackFonts.unwritable)


def _load(font: imgui.ImFont, path: Path, number: int) -> None:
    """Merge the font of a file into another one; a file that is no font changes nothing."""
    settings = imgui.ImFontConfig()
    settings.merge_mode, settings.dst_font, settings.font_no = True, font, number
    try:
        imgui.get_io().fonts.add_font_from_file_ttf(str(path), theme.TEXT_PX, settings)
    except RuntimeError:
        return


def _missing(size_px: float) -> set[int]:
    """Return the characters that were to be drawn at a size so far and are not in the font."""
    imgui.push_font(None, size_px)
    baked = imgui.get_font_baked()
    imgui.pop_font()
    widths = baked.index_advance_x
    if not widths.size():
        return set()
    # A character that is missing has the width of what stands in its place; one never asked for has none.
    taken = np.ctypeslib.as_array((ctypes.c_float * widths.size()).from_address(widths.data_address()))
    likely = ASCII + np.flatnonzero(taken[ASCII:] == np.float32(baked.fallback_advance_x))
    return {code for code in likely.tolist() if code != REPLACEMENT and not baked.is_glyph_loaded(code)}
