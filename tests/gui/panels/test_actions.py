"""Every action once, in the window: nothing fails, and what asks something shows its dialog."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from app.ui.dialogs import keys_sheet
from app.ui.dialogs.keys_sheet import balance
from app.ui.dialogs.palette import matches
from app.ui.menus import menu_tree
from app.ui.widgets import controls
from core.imaging.images import Image, save
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui

ASKING = {
    "file.new": "New from picture",
    "file.open": "Open",
    "file.save": "Save project as",
    "file.save_as": "Save project as",
    "file.export": "Export picture",
    "file.replace_picture": "Replace picture",
    "file.open_st_map": "Open an ST map as the warp",
    "file.open_displacement": "Open a displacement as the warp",
    "mask.load": "Load mask",
    "mask.save": "Save mask",
    "surface.open": "Open a mesh to lay the picture on",
    "surface.export_view": "Export the view",
    "warp.export": "Export warp: ST map (.exr) or mesh (.obj)",
    "help.tour.warp": "Save changes?",
    "help.tour.retexture": "Save changes?",
    "help.tour.overlay": "Save changes?",
}
OPEN = int(imgui.PopupFlags_.any_popup_id) | int(imgui.PopupFlags_.any_popup_level)


def test_every_action_runs(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        workspace = window.shell.workspace
        for action in workspace.table.actions:
            if action.name in ("file.quit", "mode.overlay"):
                continue
            if action.name == "surface.export_view":  # the surface is flattened in a job
                window.wait_until(lambda: editor.document.surface is not None)
            action.try_run(editor)
            window.wait(2)
            assert window.dialog == ASKING.get(action.name), action.name
            if action.release is not None:
                action.release(editor)
            if imgui.is_popup_open("", OPEN):
                window.key(imgui.Key.escape).wait(1)
            assert window.dialog is None, action.name
            workspace.sheets.shown = None
        window.wait(5)
        assert not any("error" in text.lower() for text in workspace.toasts.texts)

    drive(editor, script)
    assert editor.history.index > 20


def test_menus_run_actions(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.context.set_ref("##MainMenuBar")
        window.context.menu_click("Mask/###mask.invert")
        window.wait()

    drive(editor, script)
    assert editor.history.labels[-1] == "Invert mask"


def test_the_palette_runs_what_is_typed(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.key(imgui.Key.f3).wait()
        window.context.key_chars_append_enter("invert")
        window.wait()

    drive(editor, script)
    assert editor.history.labels[-1] == "Invert mask"


def test_the_palette_lists_what_cannot_be_done_last_and_does_not_go_by_it(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.key(imgui.Key.f3).wait()
        window.context.key_chars_append("split")
        window.wait()
        found = window.shell.workspace.palette.found()
        assert [action.name for action in found][:2] == ["view.split", "tool.split"]
        assert not found[1].enabled(editor)
        window.key(imgui.Key.down_arrow).wait().key(imgui.Key.enter).wait()
        assert imgui.is_popup_open("", OPEN)

    drive(editor, script)
    assert editor.session.tool == "brush"


def test_the_enter_that_chooses_in_the_palette_answers_no_dialog(editor: Editor, tmp_path: Path) -> None:
    editor.source_path = tmp_path / "picture.png"
    editor.edit("Bend", editor.document.with_warp(preset="arc"))

    def script(window: WindowDriver) -> None:
        for typed, title in (("bend a picture", "Save changes?"), ("export picture", "Export picture")):
            window.key(imgui.Key.f3).wait()
            window.context.key_chars_append_enter(typed)
            window.wait(5)
            assert window.dialog == title
            window.key(imgui.Key.escape).wait(3)
        window.key(imgui.Key.f3).wait()
        window.context.key_chars_append_enter("bend a picture")
        window.wait(5).key(imgui.Key.enter).wait(5)
        assert window.dialog == "Save project as"

    drive(editor, script)
    assert not list(tmp_path.iterdir())


def test_the_palette_opens_recent_files(editor: Editor, tmp_path: Path) -> None:
    save(Image(np.full((20, 30, 3), 90, np.uint8)), tmp_path / "quarry.png")
    editor.session = replace(editor.session, recent=(str(tmp_path / "quarry.png"),))

    def script(window: WindowDriver) -> None:
        window.key(imgui.Key.f3).wait()
        window.context.key_chars_append_enter("quarry")
        window.wait_until(lambda: editor.name == "quarry.png")

    drive(editor, script)
    assert editor.document.size_px == (30, 20)


def test_a_dialog_takes_a_name_typed_at_once(editor: Editor, tmp_path: Path) -> None:
    save(Image(np.full((20, 30, 3), 90, np.uint8)), tmp_path / "moor.png")

    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("file.open", editor)
        window.wait(4)
        assert window.dialog == "Open"
        window.context.key_chars_append_enter(str(tmp_path))
        window.wait(4)
        window.context.key_chars_append_enter("moor.png")
        window.wait_until(lambda: editor.name == "moor.png")

    drive(editor, script)


def test_the_palette_finds_by_initials_and_by_parts(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        actions = window.shell.workspace.table.actions
        assert matches("export", actions)[0].name == "file.export"
        assert matches("sbaa", actions)[0].name == "view.split"
        assert matches("qqqq", actions) == []
        assert len(matches("", actions)) == len(actions)

    drive(editor, script)


def test_every_action_stands_in_a_menu(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        table = window.shell.workspace.table
        tree = menu_tree(table.actions)
        overlays = tree["View"]
        assert isinstance(overlays, dict)
        assert "view.fit" in overlays
        assert isinstance(overlays["Overlays"], dict)
        assert set(tree) == {action.menu.split("/")[0] for action in table.actions}

    drive(editor, script)


def test_columns_of_keys_are_of_about_the_same_height() -> None:
    groups = [(str(n), [("k", "name", "")] * n) for n in (6, 5, 4, 3, 3, 3)]
    heights = [sum(len(rows) for _, rows in column) for column in balance(groups, 3)]
    assert max(heights) - min(heights) <= 3


def test_no_key_is_cut_on_the_sheet_of_keys(editor: Editor, monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[str] = []

    def shorten(text: str, room: float) -> str:
        shown.append(controls.shorten(text, room))
        assert shown[-1] == text
        return text

    def script(window: WindowDriver) -> None:
        monkeypatch.setattr(keys_sheet, "shorten", shorten)
        window.key(imgui.Key.f1).wait(3)
        assert {"Ctrl+Shift+Z,", "Ctrl+Y"} <= set(shown)

    drive(editor, script)
