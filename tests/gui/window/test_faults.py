"""A fault of the program in the window: it is caught and told, nothing is lost, and the editor goes on."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.actions import Action
from app.editor.editor import Editor
from app.model.requests import AskUnsaved
from app.state.recovery import Recovery
from app.ui.dialogs import export as export_dialog
from core.document.document import Document
from core.document.project import load_project
from core.progress import Job, Progress
from tests.gui.window_driver import WindowDriver, drive

pytestmark = [pytest.mark.gui, pytest.mark.filterwarnings("ignore::UserWarning")]


def failing(*_: object) -> None:
    raise ZeroDivisionError("a fault")


def half_drawn() -> None:
    """Fail in the middle of a window, a table, a group, colours and a disabled part, as a panel may."""
    imgui.begin("Half")
    imgui.begin_child("inner")
    imgui.push_style_color(imgui.Col_.text, 0xFF0000FF)
    imgui.push_id("deep")
    imgui.begin_group()
    imgui.begin_disabled()
    imgui.begin_table("table", 2)
    imgui.table_next_column()
    failing()


def bend(editor: Editor, value: float = 30.0) -> None:
    editor.edit("Bend", editor.document.with_warp(preset="arc", bend=value))


PARTS: dict[str, Callable[[WindowDriver, pytest.MonkeyPatch], None]] = {
    "menus": lambda window, patch: patch.setattr(window.shell.workspace.menus, "_draw_modes", failing),
    "marks": lambda window, patch: patch.setattr("app.ui.canvas.canvas.marks", failing),
    "input": lambda window, patch: patch.setattr(window.shell.workspace.canvas, "take_input", failing),
    "update": lambda window, patch: patch.setattr(window.editor, "update", failing),
    "scene": lambda window, patch: patch.setattr("app.window.shell.scene_of", failing),
    "renderer": lambda window, patch: patch.setattr(window.shell._renderer, "draw", failing),
    "toasts": lambda window, patch: patch.setattr(window.shell.workspace.toasts, "draw", failing),
    "palette": lambda window, patch: patch.setattr(window.shell.workspace.palette, "draw", half_drawn),
    "sheets": lambda window, patch: patch.setattr(window.shell.workspace.sheets, "draw", half_drawn),
    "welcome": lambda window, patch: patch.setattr(window.shell.workspace.welcome, "draw", lambda _: half_drawn()),
}


@pytest.mark.parametrize("part", PARTS)
def test_a_part_that_fails_in_every_frame_is_told_once_and_the_rest_goes_on(
    editor: Editor, part: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    bend(editor)

    def script(window: WindowDriver) -> None:
        with monkeypatch.context() as patch:
            PARTS[part](window, patch)
            window.wait(12)
            barrier = window.shell.workspace.barrier
            assert barrier.shown is not None
            assert barrier.shown.text == "a fault"
        window.wait(2).item("//##fault/Go on").wait(4)
        assert barrier.shown is None
        window.item("//Warp/**/Twist").wait(2)

    shell = drive(editor, script, faults=["a fault"] * (2 if part == "renderer" else 1))
    assert editor.document.warp.preset == "twist"
    assert shell.frames > 20


def test_a_panel_that_fails_half_drawn_leaves_the_others_whole(editor: Editor, monkeypatch: pytest.MonkeyPatch) -> None:
    def script(window: WindowDriver) -> None:
        monkeypatch.setattr(window.shell.workspace.handles_panel, "_editor", None)
        window.wait(6)
        window.item("//Warp/**/Arch").wait(2)

    drive(editor, script, faults=["'NoneType' object has no attribute 'document'"])
    assert editor.document.warp.preset == "arch"


def test_undo_in_the_message_takes_the_last_step_back(editor: Editor, monkeypatch: pytest.MonkeyPatch) -> None:
    bend(editor, 20.0)
    bend(editor, 50.0)

    def draw(document: Document) -> None:
        if document.warp.bend == 50.0:
            failing()

    def script(window: WindowDriver) -> None:
        workspace = window.shell.workspace
        monkeypatch.setattr(workspace.status_bar, "_draw_hint", lambda _: draw(editor.document))
        window.wait(6)
        assert workspace.barrier.shown is not None
        window.item("//##fault/Undo").wait(6)
        assert workspace.barrier.shown is None

    drive(editor, script, faults=["a fault"])
    assert editor.document.warp.bend == 20.0


def test_a_report_is_copied_and_written(editor: Editor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))

    def script(window: WindowDriver) -> None:
        with monkeypatch.context() as patch:
            patch.setattr(window.shell.workspace.status_bar, "draw", failing)
            patch.setattr(window.shell.workspace.status_bar, "_draw_hint", failing)
            window.wait(4)
        window.item("//##fault/Report").wait(2)
        assert "ZeroDivisionError: a fault" in imgui.get_clipboard_text()

    drive(editor, script, faults=["a fault"])
    (report,) = (tmp_path / "weft" / "faults").iterdir()
    text = report.read_text()
    assert "ZeroDivisionError: a fault" in text
    assert "picture 600 x 400" in text


def test_an_action_that_fails_by_menu_or_key_changes_nothing(editor: Editor, monkeypatch: pytest.MonkeyPatch) -> None:
    bend(editor)
    before = editor.document

    def run(editor: Editor) -> None:
        with editor.group("Half"):
            bend(editor, 3.0)
            failing()

    def script(window: WindowDriver) -> None:
        table = window.shell.workspace.table
        action = table.by_name["mask.invert"]
        object.__setattr__(action, "run", run)
        window.context.set_ref("##MainMenuBar")
        window.context.menu_click("Mask/###mask.invert")
        window.wait(4)
        assert editor.document is before
        window.key(imgui.Key.mod_ctrl, imgui.Key.i).wait(4)
        assert editor.document is before
        window.item("//Warp/**/Twist").wait(2)

    invert = _invert()
    run_before = invert.run
    try:
        drive(editor, script, faults=["a fault", "a fault"])
    finally:
        object.__setattr__(invert, "run", run_before)
    assert editor.document.warp.preset == "twist"


def _invert() -> Action:
    from app.actions.warp import MASK

    return next(action for action in MASK if action.name == "mask.invert")


def test_a_dialog_that_fails_is_closed(editor: Editor, monkeypatch: pytest.MonkeyPatch) -> None:
    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("file.export", editor)
        window.wait(4)
        monkeypatch.setattr(export_dialog.ExportDialog, "_draw_size", failing)
        window.wait(4)
        assert window.dialog is None
        window.move(300, 300).key(imgui.Key.h).wait()
        assert editor.session.tool == "hand"

    drive(editor, script, faults=["a fault"])


def test_work_is_kept_at_once_when_something_fails(
    editor: Editor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    editor.recovery = Recovery(editor.jobs, folder=tmp_path, every_s=600.0)

    def script(window: WindowDriver) -> None:
        bend(editor, 44.0)
        with monkeypatch.context() as patch:
            patch.setattr("app.ui.canvas.canvas.marks", failing)
            window.wait_until(lambda: bool(list(tmp_path.glob("*.json"))))

    drive(editor, script, faults=["a fault"])
    (kept,) = tmp_path.glob("*.weft")
    assert load_project(kept).warp.bend == 44.0


def test_the_last_good_picture_stays_where_drawing_fails(
    editor: Editor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def script(window: WindowDriver) -> None:
        area = window.shell.workspace.canvas.area
        rows = slice(int(area.y + area.height * 0.5), int(area.y + area.height * 0.8))
        columns = slice(int(area.x + area.width * 0.3), int(area.x + area.width * 0.7))
        good = window.screenshot(tmp_path / "good.png")[rows, columns]
        with monkeypatch.context() as patch:
            patch.setattr("app.window.shell.scene_of", failing)
            window.wait(4)
            stays = window.screenshot(tmp_path / "stays.png")[rows, columns]
        assert np.array_equal(good, stays)
        assert good.std() > 5

    drive(editor, script, faults=["a fault"])


def test_closing_asks_for_unsaved_work_after_a_fault(editor: Editor, monkeypatch: pytest.MonkeyPatch) -> None:
    def script(window: WindowDriver) -> None:
        bend(editor)
        monkeypatch.setattr(window.shell.workspace.status_bar, "_draw_hint", failing)
        window.wait(4)
        window.shell.workspace.table.run("file.quit", editor)
        assert isinstance(editor.requests[-1], AskUnsaved)
        editor.requests.clear()

    drive(editor, script, faults=["a fault"])


def test_every_setting_at_its_end_leaves_the_window_standing(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        editor.choose_tool("outline")
        for name in ("top-left-x", "top-right-y", "bottom-right-x", "bottom-left-y"):
            for value in (-100.0, 100.0):
                warp = replace(editor.document.warp, preset="perspective", values={name: value})
                editor.edit("Setting", editor.document.changed(warp=warp))
                window.move(300, 200).wait(2)
                editor.show(selected_corners=frozenset({0}))
                window.wait(2)

    drive(editor, script)


def test_a_fault_in_the_background_is_told_too(editor: Editor) -> None:
    def steps() -> Job[None]:
        yield Progress(0.5)
        failing()

    def script(window: WindowDriver) -> None:
        editor.background("Fail", steps, failing)
        barrier = window.shell.workspace.barrier
        window.wait_until(lambda: barrier.shown is not None)
        assert barrier.shown is not None
        assert "in steps" in barrier.shown.report
        window.item("//##fault/Go on").wait(2)

    drive(editor, script, faults=["a fault"])
