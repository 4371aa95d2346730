"""A dialog opens in the middle of the window, and stays where it is whatever it holds."""

from pathlib import Path

import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from app.ui.dialogs.export import ExportDialog
from app.ui.dialogs.requested import BrowserDialog
from tests.gui.window.test_small_windows import resize
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui

SIZE = (1280, 800)


def corner(window: WindowDriver) -> tuple[float, float]:
    """Return where the open dialog is."""
    found = window.context.window_info(f"//{window.dialog}").window
    assert found is not None
    return found.pos.x, found.pos.y


def middle(window: WindowDriver) -> tuple[float, float]:
    """Return where the middle of the open dialog is."""
    found = window.context.window_info(f"//{window.dialog}").window
    assert found is not None
    return found.pos.x + found.size.x / 2, found.pos.y + found.size.y / 2


def dialog(window: WindowDriver) -> object:
    """Return the open dialog."""
    return window.shell.workspace.dialogs._dialog


def check_in_the_middle(window: WindowDriver) -> None:
    """Check that the open dialog is where it should be."""
    assert middle(window) == pytest.approx((SIZE[0] / 2, SIZE[1] / 2), abs=1)


@pytest.mark.parametrize("action", ["file.export", "file.open", "file.save_as"])
def test_a_dialog_opens_in_the_middle(editor: Editor, tmp_path: Path, action: str) -> None:
    editor.source_path = tmp_path / "picture.png"

    def script(window: WindowDriver) -> None:
        for _ in range(2):
            window.shell.workspace.table.run(action, editor)
            window.wait(5)
            check_in_the_middle(window)
            window.key(imgui.Key.escape).wait(3)

    drive(editor, script, size=SIZE)


def test_the_export_dialog_stays_where_it_is(editor: Editor, tmp_path: Path) -> None:
    editor.source_path = tmp_path / "picture.png"

    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("file.export", editor)
        window.wait(5)
        place, export = corner(window), dialog(window)
        assert isinstance(export, ExportDialog)
        for chosen in ("exr", "jpg", "tif", "png"):
            export.choose_format(chosen)
            window.wait(3)
            assert corner(window) == place
        for name in ("/" * 90, "a.png"):
            export.write_to(name)
            window.wait(3)
            assert corner(window) == place
        window.item("//Export picture/Browse …").wait(4)
        assert corner(window) == place
        window.key(imgui.Key.escape).wait(3)
        assert corner(window) == place

    drive(editor, script, size=SIZE)


def test_a_file_dialog_stays_where_it_is(editor: Editor, tmp_path: Path) -> None:
    for number in range(60):
        (tmp_path / f"{number}{'x' * number}.png").write_bytes(b"x")
    editor.source_path = tmp_path / "picture.png"

    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("file.open", editor)
        window.wait(5)
        place, browser = corner(window), dialog(window)
        assert isinstance(browser, BrowserDialog)
        for folder in (Path("/"), tmp_path, tmp_path.parent):
            browser._browser.enter(folder)
            window.wait(3)
            assert corner(window) == place

    drive(editor, script, size=SIZE)


def test_a_dialog_is_in_the_middle_of_a_window_that_gets_smaller_under_it(editor: Editor, tmp_path: Path) -> None:
    editor.source_path = tmp_path / "picture.png"

    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("file.export", editor)
        window.wait(5)
        resize(window, 940, 640)
        window.wait(4)
        assert middle(window) == pytest.approx((470, 320), abs=1)

    drive(editor, script, size=SIZE)


def test_a_dialog_is_in_the_middle_when_its_text_gets_larger(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("edit.preferences", editor)
        window.wait(5)
        editor.prefer(editor.preferences.changed(scale=1.5))
        window.wait(8)
        found = window.context.window_info("//Preferences").window
        assert found is not None
        assert found.pos.x + found.size.x / 2 == pytest.approx(SIZE[0] / 2, abs=1)
        assert found.pos.y + found.size.y / 2 == pytest.approx(SIZE[1] / 2, abs=1)

    drive(editor, script, size=SIZE)
