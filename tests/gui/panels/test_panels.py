"""Panels, sheets and the status bar in the window."""

from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import hello_imgui, imgui

from app.editor.editor import Editor
from app.model.jobs import InlineExecutor, Jobs
from app.state.preferences import load_preferences
from app.state.recovery import Recovery
from app.ui.panels.preset_list import PresetList
from app.ui.status_bar import StatusBar
from app.ui.widgets import theme
from core.arrays import Bytes
from core.document.document import Document, Mode, Pin, pixels_from_places
from core.document.map import outline_of
from core.rasters.raster import Raster
from core.warps.presets import PRESETS
from tests.app.driver import EditorDriver, Later, picture
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


def test_the_place_of_a_pin_is_typed(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        editor.edit("Pin", editor.document.changed(pins=(Pin((0.5, 0.5), (0.5, 0.5)),)))
        editor.show(selected=frozenset({0}))
        window.wait(4).context.item_input_value("//Handles/pin 0/##x", -25.0)
        window.wait(2).context.item_input_value("//Handles/pin 0/##y", 120.5)
        window.wait(2)

    drive(editor, script)
    assert pixels_from_places((600, 400), np.array(editor.document.pins[0].to)) == pytest.approx((-25.0, 120.5))
    assert editor.document.pins[0].at == (0.5, 0.5)
    assert editor.history.labels[-2:] == ("Move pin", "Move pin")


def test_the_place_of_a_corner_is_typed(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        editor.choose_tool("outline")
        editor.show(selected_corners=frozenset({2}))
        window.wait(4).context.item_input_value("//Handles/corner 2/##x", 700.0)
        window.wait(2)

    drive(editor, script)
    corner = pixels_from_places((600, 400), outline_of(editor.document).ring[6])
    assert corner == pytest.approx((700.0, 399.5))
    assert editor.history.labels[-1] == "Move corner"


def test_the_status_bar_says_what_is_true_in_the_mode(editor: Editor) -> None:
    said: dict[Mode, str] = {}

    opened = []

    def figures(window: WindowDriver) -> str:
        return " ".join(text for text, _, _ in window.wait(2).shell.workspace.status_bar.figures())

    def script(window: WindowDriver) -> None:
        opened.append(figures(window))
        editor.choose_tool("pins")
        window.drag((300, 200), (320, 210), (330, 220))
        modes: tuple[Mode, ...] = ("warp", "retexture", "overlay")
        for mode in modes:
            editor.choose_mode(mode)
            said[mode] = figures(window)

    drive(editor, script)
    assert all("600 × 400 px" in text for text in said.values())
    assert " ms" not in opened[0], "nothing has moved"
    assert [word in said["warp"] for word in (" ms", "fold")] == [True, True]
    for mode in ("retexture", "overlay"):
        assert not [word for word in (" ms", "fold") if word in said[mode]]


def test_what_a_solve_took_is_not_said_of_another_picture(editor: Editor) -> None:
    said: list[str] = []

    def script(window: WindowDriver) -> None:
        editor.choose_tool("pins")
        window.drag((300, 200), (320, 210), (330, 220))
        for _ in range(2):
            figures = window.wait(3).shell.workspace.status_bar.figures()
            said.append(" ".join(text for text, _, _ in figures))
            editor.replace_document(Document.of(picture(500, 300)), project=None, source=None)

    drive(editor, script)
    assert [" ms" in text for text in said] == [True, False]


def test_the_status_bar_says_that_the_outline_gives_way(editor: Editor) -> None:
    band = np.zeros((400, 600), np.uint8)
    band[240:300] = 255
    bent = editor.document.with_warp(preset="arc", bend=90.0, cell_px=20.0)
    said = []

    def script(window: WindowDriver) -> None:
        for document in (bent, bent.changed(mask=Raster.from_array(band))):
            editor.edit("Warp", document)
            window.wait(2).wait_until(lambda: editor.live.is_settled).wait(2)
            said.append(" ".join(text for text, _, _ in window.shell.workspace.status_bar.figures()))

    drive(editor, script)
    assert ["outline off by" in text for text in said] == [False, True]
    assert all("no folds" in text for text in said)


def test_text_and_controls_take_the_preferred_size_at_once(editor: Editor, tmp_path: Path) -> None:
    editor.preferences_file = tmp_path / "preferences.json"
    sizes: list[tuple[float, float]] = []

    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("edit.preferences", editor)
        window.wait(3)
        sizes.append((imgui.get_font_size(), imgui.get_style().item_spacing.x))
        window.item("//Preferences/150%##scale").wait(3)
        sizes.append((imgui.get_font_size(), imgui.get_style().item_spacing.x))

    drive(editor, script)
    (text, gap), (larger_text, larger_gap) = sizes
    assert larger_text == pytest.approx(1.5 * text, abs=1)
    assert larger_gap == pytest.approx(1.5 * gap, abs=1)
    assert load_preferences(editor.preferences_file).scale == 1.5


def test_the_panels_go_back_to_where_they_were(editor: Editor) -> None:
    places: list[tuple[float, float]] = []

    def place() -> tuple[float, float]:
        window = imgui.internal.find_window_by_name("History")
        return (window.pos.x, window.pos.y)

    def script(window: WindowDriver) -> None:
        places.append(place())
        window.context.undock_window("History")
        window.wait(3).context.window_move("//History", imgui.ImVec2(200, 200))
        places.append(place())
        window.shell.workspace.table.run("view.reset_panels", editor)
        window.wait(8)
        hello_imgui.get_runner_params().docking_params.focus_dockable_window("History")
        window.wait(3)
        places.append(place())

    drive(editor, script)
    first, moved, last = places
    assert moved != first
    assert last == pytest.approx(first, abs=2)


def test_docked_and_floating_panels_have_a_ground(editor: Editor, tmp_path: Path) -> None:
    shots: list[tuple[Bytes, tuple[int, int]]] = []

    def script(window: WindowDriver) -> None:
        def shoot(label: str) -> None:
            panel = window.wait(4).context.get_window_by_ref(f"//{label}")
            place = round(panel.pos.x + panel.size.x / 2), round(panel.pos.y + panel.size.y - 12)
            shots.append((window.screenshot(tmp_path / "window.png"), place))

        shoot("Handles")
        window.context.undock_window("//Handles")
        window.context.window_move("//Handles", window.place(200, 150))
        shoot("Handles")
        window.context.dock_into("//History", "//Handles")
        shoot("History")

    drive(editor, script)
    for pixels, (x, y) in shots:
        code = theme.PANEL
        assert tuple(pixels[y, x]) == (code >> 16 & 255, code >> 8 & 255, code & 255)


def test_the_place_under_the_pointer_waits_while_a_gesture_bends_the_picture(editor: Editor) -> None:
    said: list[str] = []

    def script(window: WindowDriver) -> None:
        def say() -> None:
            figures = window.shell.workspace.status_bar.figures()
            said.append(next(text for text, meaning, _ in figures if "under the pointer" in meaning))

        editor.choose_tool("pins")
        window.click(200, 300).click(700, 300).move(300, 300).wait(2)
        say()
        window.press(200, 300).wait(2)
        say()
        window.move(260, 340).wait(2)
        say()
        window.release().wait(2)
        say()
        window.move(400, 300).wait(2)
        say()

    drive(editor, script)
    assert len(set(said[:2])) == 2
    assert said[1] == said[2] == said[3]  # a pin takes along what it is put on
    assert said[4] != said[3]


def test_the_status_bar_says_that_unsaved_work_is_not_kept_until_it_is(editor: Editor, tmp_path: Path) -> None:
    folder = tmp_path / "state"
    folder.write_text("in the way")
    editor.recovery = Recovery(editor.jobs, folder=folder, every_s=0.05)

    def script(window: WindowDriver) -> None:
        def is_said() -> bool:
            figures = window.shell.workspace.status_bar.figures()
            return any("Unsaved work is not kept" in text for text, _, _ in figures)

        editor.edit("Bend", editor.document.with_warp(preset="arc", bend=10.0))
        window.wait_until(is_said)
        folder.unlink()
        window.wait_until(lambda: not is_said())

    drive(editor, script)
    assert sorted(file.suffix for file in folder.iterdir()) == [".json", ".lock", ".png", ".weft"]


def test_the_status_bar_says_that_the_final_map_is_worked_out() -> None:
    later = Later()
    driven = EditorDriver(jobs=Jobs(live=later, long=InlineExecutor(), beside=InlineExecutor()))

    def is_said() -> bool:
        return any(text == "finishing …" for text, _, _ in StatusBar(driven.editor).figures())

    assert not is_said(), "the first answer comes at once"
    later.run()
    driven.rest()
    assert is_said()
    later.run()
    driven.frame()
    assert driven.editor.answer.settled
    assert not is_said()


def test_pins_are_not_looked_for_before_the_final_map_is_there() -> None:
    driven = EditorDriver()
    driven.editor.edit("Pin", driven.editor.document.changed(pins=(Pin((0.5, 0.5), (0.6, 0.5)),)))
    answer = driven.frame().editor.map
    assert answer.result is not None
    assert not answer.settled
    StatusBar(driven.editor).figures()
    assert "missed_pins" not in vars(answer.result)


def test_the_presets_take_a_draw_call_each_at_most_and_one_for_all_their_names(
    editor: Editor, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls, draw = [], PresetList.draw

    def counted(self: PresetList, chosen: str) -> str | None:
        sheet = imgui.get_window_draw_list()
        before = len(sheet.cmd_buffer)
        pressed = draw(self, chosen)
        calls.append(len(sheet.cmd_buffer) - before)
        return pressed

    monkeypatch.setattr(PresetList, "draw", counted)

    def script(window: WindowDriver) -> None:
        window.wait_until(lambda: window.shell.workspace.thumbnails.is_complete).wait(20)

    drive(editor, script)
    assert calls[-1] <= len(PRESETS) + 2
