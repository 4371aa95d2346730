"""Characters that the window's own font lacks: drawn in a font of the system, or written by their numbers."""

import subprocess
from pathlib import Path

import imgui_bundle
import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from app.state import system_fonts
from app.state.system_fonts import find_fonts
from app.ui.widgets import fallback_fonts
from app.ui.widgets.fallback_fonts import FallbackFonts, writable
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui
FONT = Path(imgui_bundle.__file__).parent / "assets/fonts/latex/latinmodern-math.otf"
IN_FONT, IN_NONE = "∀", "文"


def test_a_font_joins_when_its_characters_are_shown_and_not_before(
    editor: Editor, monkeypatch: pytest.MonkeyPatch
) -> None:
    looked: list[str] = []

    def find(code: int) -> list[tuple[Path, int]]:
        looked.append(chr(code))
        return [(Path(__file__), 0), (FONT, 0)] if chr(code) == IN_FONT else []

    monkeypatch.setattr(fallback_fonts, "find_fonts", find)
    monkeypatch.setattr(FallbackFonts, "unwritable", {})

    def script(window: WindowDriver) -> None:
        def has(character: str) -> bool:
            return imgui.get_io().fonts.fonts[0].is_glyph_in_font(ord(character))

        window.wait(4)
        assert not looked
        assert not has(IN_FONT)
        editor.notify(f"Saved {IN_FONT}{IN_NONE}é.png")
        window.wait_until(lambda: has(IN_FONT)).wait(2)
        assert sorted(looked) == [IN_FONT, IN_NONE]
        assert writable(f"{IN_FONT}{IN_NONE}é.png") == f"{IN_FONT}\\u6587é.png"

    drive(editor, script)


def test_fontconfig_is_asked_for_a_font_that_has_the_character(monkeypatch: pytest.MonkeyPatch) -> None:
    said = b"/fonts/a.ttc\t65538\t20-7e 4e00-9fa5"

    def answer(command: list[str], **_: object) -> subprocess.CompletedProcess[bytes]:
        assert command[-1].endswith(":charset=4e2d") or command[-1].endswith(":charset=e01")
        return subprocess.CompletedProcess(command, 0, said)

    monkeypatch.setattr(subprocess, "run", answer)
    assert find_fonts(0x4E2D) == [(Path("/fonts/a.ttc"), 2)]
    assert find_fonts(0x0E01) == []


def test_without_fontconfig_the_fonts_that_systems_come_with_are_looked_for(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise FileNotFoundError

    fonts = tmp_path / "Fonts"
    (fonts / "more").mkdir(parents=True)
    for name in ("malgun.ttf", "other.ttf", "more/msyh.ttc"):
        (fonts / name).touch()
    monkeypatch.setattr(subprocess, "run", fail)
    monkeypatch.setattr(system_fonts.sys, "platform", "win32")  # type: ignore[attr-defined]  # the module's own
    monkeypatch.setenv("WINDIR", str(tmp_path))
    assert find_fonts(0x4E2D) == [(fonts / "more/msyh.ttc", 0), (fonts / "malgun.ttf", 0)]
