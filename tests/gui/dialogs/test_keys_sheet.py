"""Keys in the window: whose they are, and setting another one."""

from pathlib import Path
from typing import Any

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


@pytest.mark.parametrize("text_scale", [1.0, 2.0])
def test_no_key_and_no_meaning_is_cut_off(editor: Editor, monkeypatch: pytest.MonkeyPatch, text_scale: float) -> None:
    editor.prefer(editor.preferences.changed(scale=text_scale))
    beyond: dict[str, float] = {}

    write = imgui.text_wrapped

    def note(text: str) -> None:
        write(text)
        if imgui.table_get_column_count():
            end = imgui.get_cursor_screen_pos().x + imgui.get_content_region_avail().x
            beyond[text] = imgui.get_item_rect_max().x - end

    select = imgui.selectable

    def note_key(text: str, *look: Any) -> tuple[bool, bool]:
        if imgui.table_get_column_count():
            beyond[text] = imgui.calc_text_size(text.split("##", maxsplit=1)[0]).x - look[-1].x
        return select(text, *look)

    monkeypatch.setattr(imgui, "text_wrapped", note)
    monkeypatch.setattr(imgui, "selectable", note_key)

    def script(window: WindowDriver) -> None:
        window.move(300, 300).key(imgui.Key.f1).wait(6)

    drive(editor, script)
    assert max(beyond.values()) <= 0
    assert "Move what is selected by a pixel, with Shift by ten" in beyond


def test_what_is_held_with_the_pointer_is_set_in_the_sheet_and_works(editor: Editor, tmp_path: Path) -> None:
    editor.preferences_file = tmp_path / "preferences.json"

    def held(window: WindowDriver, *keys: imgui.Key) -> None:
        for key in keys:
            window.context.key_down(int(key))
        window.wait(2)
        for key in keys:
            window.context.key_up(int(key))
        window.wait(2)

    def script(window: WindowDriver) -> None:
        window.move(300, 300).key(imgui.Key.f1).wait(4)
        window.screenshot(tmp_path / "pointer.png")
        window.item("//Keys/**/Shift-drag##pointer.select.add").wait(2)
        held(window, imgui.Key.mod_ctrl, imgui.Key.mod_shift)
        assert editor.preferences.keys == (("pointer.select.add", "Ctrl+Shift"),)
        window.item("//Keys/**/Alt-drag##pointer.select.cut").wait(2).key(imgui.Key.escape).wait(2)
        window.item("//Keys/**/Space-drag##pointer.pan").wait(2).key(imgui.Key.k).wait(2)
        window.screenshot(tmp_path / "set.png")
        window.key(imgui.Key.escape).wait(3).move(300, 300).key(imgui.Key.r).wait(2)
        assert "Ctrl+Shift adds" in window.shell.workspace.status_bar.hint
        area, view = window.shell.workspace.canvas.area, editor.session.view
        x, y = area.width / 2, area.height / 2
        window.drag((x - 60, y - 20), (x - 30, y), (x - 20, y + 20)).wait(2)
        once = int((editor.document.mask.array > 127).sum())
        for key in (imgui.Key.mod_ctrl, imgui.Key.mod_shift):
            window.context.key_down(int(key))
        window.drag((x + 20, y - 20), (x + 50, y), (x + 60, y + 30)).wait(2)
        for key in (imgui.Key.mod_ctrl, imgui.Key.mod_shift):
            window.context.key_up(int(key))
        assert int((editor.document.mask.array > 127).sum()) > once > 0
        window.context.key_down(int(imgui.Key.k))
        window.wait(2).drag((x, y), (x + 40, y)).wait(2)
        window.context.key_up(int(imgui.Key.k))
        window.wait(2)
        assert editor.session.view.pan[0] == pytest.approx(view.pan[0] + 40, abs=1)
        window.key(imgui.Key.f1).wait(4).item("//Keys/Krita##preset").wait(3)
        window.screenshot(tmp_path / "krita.png")
        window.key(imgui.Key.escape).wait(3).move(x, y).key(imgui.Key.z).wait(2)
        zoom = editor.session.view.zoom
        window.context.key_down(int(imgui.Key.mod_ctrl))
        window.click(x, y).wait(2)
        window.context.key_up(int(imgui.Key.mod_ctrl))
        assert editor.session.view.zoom < zoom

    drive(editor, script)
