"""Keys in the window: whose they are, and setting another one."""

from pathlib import Path

import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


def test_a_key_is_set_in_the_sheet_and_works(editor: Editor, tmp_path: Path) -> None:
    editor.preferences_file = tmp_path / "preferences.json"

    def script(window: WindowDriver) -> None:
        window.move(300, 300).key(imgui.Key.f1).wait(4)
        window.screenshot(tmp_path / "keys.png")
        window.context.mouse_wheel_y(-20)
        window.wait(4)
        window.item("//Keys/**/P##tool.pins").wait(2).key(imgui.Key.y).wait(3)
        assert editor.preferences.keys == (("tool.pins", "Y"),)
        window.context.mouse_wheel_y(-20)
        window.wait(4).item("//Keys/**/Y##tool.pins").wait(2).key(imgui.Key.escape).wait(2)
        assert window.shell.workspace.sheets.shown == "keys"
        window.key(imgui.Key.escape).wait(3)
        assert window.shell.workspace.sheets.shown is None
        window.move(300, 300).key(imgui.Key.y).wait(2)
        assert editor.session.tool == "pins"
        window.key(imgui.Key.f1).wait(4).item("//Keys/Photoshop##preset").wait(3)
        assert editor.preferences.keys == ()
        window.key(imgui.Key.escape).wait(3).move(300, 300).key(imgui.Key.m).wait(2)
        assert editor.session.tool == "rectangle"

    drive(editor, script)
    assert '"photoshop"' in (tmp_path / "preferences.json").read_text()
