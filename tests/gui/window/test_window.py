"""The window as a whole: it shows the picture, hands mouse and keys to the tools, and every action runs."""

import os
import time
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from app.model.requests import AskRecover, Offer, OpenFile
from app.model.spaces import canvas_from_screen
from app.ui.widgets import toasts
from core.imaging.images import Image, save
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


def moved(place: imgui.ImVec2, by: float) -> imgui.ImVec2:
    """Return a place farther to the right."""
    return imgui.ImVec2(place.x + by, place.y)


def test_a_stroke_of_the_mouse_paints_the_mask(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        editor.choose_tool("brush")
        window.drag((300, 300), (360, 300), (420, 320))

    drive(editor, script)
    assert editor.history.labels[-1] == "Paint mask"
    assert not editor.document.mask.is_empty


def test_a_stroke_follows_the_mouse_between_two_frames(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.press(300, 300)
        way = window.place(330, 380)
        window.shell.workspace.canvas.hear_pointer(way.x, way.y)
        window.shell.workspace.canvas.hear_pointer(0, 0)
        window.move(360, 300).release()
        x, y = canvas_from_screen(editor.session.view, np.array([330.0, 380.0]))
        assert editor.document.mask.array[round(y), round(x)] == 255

    drive(editor, script)


def test_keys_reach_tools_and_actions(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        size = editor.session.brush.diameter_px
        window.move(300, 300).key(imgui.Key.right_bracket)
        assert editor.session.brush.diameter_px > size
        window.key(imgui.Key.h).wait()
        assert editor.session.tool == "hand"
        window.key(imgui.Key.mod_ctrl, imgui.Key.i).wait()
        assert editor.history.labels[-1] == "Invert mask"
        window.key(imgui.Key.mod_ctrl, imgui.Key.z).wait()
        assert editor.history.index == 0

    drive(editor, script)


def test_typing_in_a_field_presses_no_keys_of_the_editor(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.item("//Warp/Horizontal/##number").wait()
        window.key(imgui.Key.h).key(imgui.Key.g).wait().key(imgui.Key.escape)

    drive(editor, script)
    assert editor.session.tool == "brush"
    assert not editor.session.overlays.grid


def test_wheel_and_middle_button_move_the_view(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        before = editor.session.view
        window.move(400, 300).context.mouse_wheel_y(1)
        window.wait()
        zoomed = editor.session.view
        assert zoomed.zoom > before.zoom
        window.drag((400, 300), (450, 320), button=2)
        panned = editor.session.view
        assert panned.pan == pytest.approx((zoomed.pan[0] + 50, zoomed.pan[1] + 20), abs=2)

    drive(editor, script)


def test_a_slider_is_one_entry_however_long_it_is_dragged(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.item("//Warp/**/Arch").wait()
        window.context.mouse_move("//Warp/Bend/##track")
        window.context.mouse_down(0)
        for _ in range(4):
            window.context.mouse_move_to_pos(moved(imgui.get_io().mouse_pos, 6))
            assert editor.is_busy
        window.release().wait()

    drive(editor, script)
    assert editor.history.labels == ("Open", "Preset Arch", "Bend")
    assert editor.document.warp.bend not in (0, 50)


def test_a_number_can_be_typed(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.item("//Warp/**/Arch").wait()
        window.context.item_input_value("//Warp/Bend/##number", -37.0)
        window.wait()

    drive(editor, script)
    assert editor.document.warp.bend == -37.0
    assert editor.history.labels[-1] == "Bend"


def test_a_job_shows_in_the_status_bar_and_is_cancelled_there(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        editor.source_path = tmp_path / "picture.png"
        window.key(imgui.Key.mod_ctrl, imgui.Key.e).wait(3)
        assert window.dialog == "Export picture"
        window.item("//Export picture/Export").wait(3)
        assert [job.name for job in editor.jobs.long_jobs] == ["Export picture-weft.png"]
        window.item("//StatusBar/###Cancel job").wait_until(lambda: not editor.jobs.long_jobs)

    drive(editor, script)


def test_a_file_dropped_on_the_window_opens(editor: Editor, tmp_path: Path) -> None:
    from core.imaging.images import save

    picture = tmp_path / "dropped.png"
    save(editor.document.image.with_pixels(editor.document.image.pixels[:100]), picture)

    def script(window: WindowDriver) -> None:
        window.shell.workspace.drop([picture])
        window.wait_until(lambda: editor.name == "dropped.png")

    drive(editor, script)
    assert editor.document.size_px == (600, 100)


def test_unsaved_changes_hold_the_window_open(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        editor.choose_tool("brush")
        window.drag((300, 300), (360, 300))
        assert not window.shell.may_close()
        window.wait(3)
        assert window.dialog == "Save changes?"
        window.item("//Save changes?/Cancel").wait()
        assert not editor.is_closing
        window.shell.may_close()
        window.wait(3).item("//Save changes?/Save").wait(3)
        assert window.dialog == "Save project as"
        window.context.item_input_value("//Save project as/##name", str(tmp_path / "kept.weft"))
        window.wait_until(lambda: editor.is_closing)  # the Enter that ends the typing has saved

    drive(editor, script)
    assert (tmp_path / "kept.weft").is_file()


def test_the_window_shows_the_picture_between_its_panels(editor: Editor, tmp_path: Path) -> None:
    shot: list[np.ndarray] = []

    def script(window: WindowDriver) -> None:
        editor.choose_tool("hand")
        window.context.mouse_move_to_pos(window.place(5, 5))
        window.wait(6)
        view, area = editor.session.view, window.shell.workspace.canvas.area
        pixels = window.screenshot(tmp_path / "window.png")
        for x, y in ((155, 105), (305, 205), (455, 305)):
            seen = pixels[round(area.y + view.pan[1] + y * view.zoom), round(area.x + view.pan[0] + x * view.zoom)]
            np.testing.assert_allclose(seen, editor.document.image.pixels[y, x], atol=3)
        shot.append(pixels)

    drive(editor, script)
    assert (shot[0][500, -20] < 80).all()


def test_a_double_click_on_a_slider_types_its_value(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.item("//Warp/**/Arch").wait()
        window.context.item_double_click("//Warp/Bend/##track")
        window.wait().context.key_chars_replace_enter("-12")
        window.wait()

    drive(editor, script)
    assert editor.document.warp.bend == -12.0


def test_before_is_shown_as_long_as_its_key_is_held(editor: Editor) -> None:
    seen: list[str] = []

    def script(window: WindowDriver) -> None:
        window.move(300, 300).context.key_down(imgui.Key.backslash)
        window.wait()
        seen.append(editor.session.compare)
        window.context.key_up(imgui.Key.backslash)
        window.wait()
        seen.append(editor.session.compare)

    drive(editor, script)
    assert seen == ["before", "result"]


def test_the_divider_of_the_split_view_is_dragged(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("view.split", editor)
        width = window.shell.workspace.canvas.area.width
        window.drag((width / 2, 200), (width / 4, 220))

    drive(editor, script)
    assert editor.session.split == pytest.approx(0.25, abs=0.01)
    assert editor.history.index == 0


def test_rescued_work_is_chosen_by_keys(editor: Editor) -> None:
    answers: list[int | None] = []
    offers = tuple(Offer(f"portrait {number}.weft", "", 1.7e9) for number in range(3))
    editor.requests.append(AskRecover(offers, answers.append))

    def script(window: WindowDriver) -> None:
        window.wait(4)
        for key in (imgui.Key.down_arrow, imgui.Key.down_arrow, imgui.Key.up_arrow):
            window.key(key).wait(2)
        window.key(imgui.Key.enter).wait_until(lambda: bool(answers))

    drive(editor, script)
    assert answers == [1]


def test_rescued_work_is_offered(editor: Editor, tmp_path: Path) -> None:
    answers: list[int | None] = []
    save(Image(np.full((8, 12, 3), 90, np.uint8)), tmp_path / "small.png")
    offers = (
        Offer("portrait.weft", "/home/a/pictures", 1.7e9, picture=tmp_path / "small.png"),
        Offer("portrait.weft", "", 1.6e9, earlier=True, picture=tmp_path / "gone.png"),
        Offer("Unsaved work", "", 1e300),
    )
    editor.requests.append(AskRecover(offers, answers.append))

    def script(window: WindowDriver) -> None:
        window.wait(3).item("//Recover unsaved work?/**/##offer 1").wait()
        window.item("//Recover unsaved work?/Recover").wait()
        assert window.dialog is None

    drive(editor, script)
    assert answers == [1]


def test_the_dialog_of_the_desktop_is_used_where_there_is_one(
    editor: Editor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "zenity"
    program.write_text(f"#!/bin/sh\necho {tmp_path / 'chosen.png'}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    chosen: list[Path] = []
    editor.requests.append(OpenFile("Open", ("png",), chosen.append))

    def script(window: WindowDriver) -> None:
        window.wait_until(lambda: bool(chosen))

    drive(editor, script)
    assert chosen == [tmp_path / "chosen.png"]


def test_a_bad_file_dropped_is_said_and_changes_nothing(editor: Editor, tmp_path: Path) -> None:
    path = tmp_path / "broken.png"
    path.write_bytes(b"not a picture")
    start = editor.document

    def script(window: WindowDriver) -> None:
        window.shell.workspace.drop([path])
        window.wait_until(lambda: any("broken.png" in text for text in window.shell.workspace.toasts.texts))
        window.item("//##toast0/###close toast 0").wait(3)
        assert window.shell.workspace.toasts.texts == ()

    drive(editor, script)
    assert editor.document is start


def test_a_fault_stays_until_somebody_is_there(editor: Editor, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(toasts.SECONDS, "error", 0.2)
    monkeypatch.setitem(toasts.SECONDS, "info", 0.2)
    seen: list[tuple[str, ...]] = []

    def script(window: WindowDriver) -> None:
        window.move(300, 300).wait(3)
        editor.notify("It failed.", "error")
        editor.notify("It is done.")
        window.wait(3)
        seen.append(window.shell.workspace.toasts.texts)
        window.wait_until(lambda: window.shell.workspace.toasts.texts == ("It failed.",))
        ends = time.monotonic() + 0.5
        window.wait_until(lambda: time.monotonic() > ends)
        seen.append(window.shell.workspace.toasts.texts)
        window.move(310, 300).wait_until(lambda: not window.shell.workspace.toasts.texts)

    drive(editor, script)
    assert seen == [("It failed.", "It is done."), ("It failed.",)]


def test_the_title_has_a_star_while_there_are_unsaved_changes(editor: Editor) -> None:
    titles: list[str] = []

    def script(window: WindowDriver) -> None:
        titles.append(window.wait().shell.title)
        editor.edit("Bend", editor.document.with_warp(bend=10.0))
        titles.append(window.wait().shell.title)

    drive(editor, script)
    assert titles == ["Untitled – Weft", "*Untitled – Weft"]
