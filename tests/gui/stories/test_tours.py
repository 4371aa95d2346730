"""The tours: each step waits for its deed, which mouse and keys do."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.actions import dropped
from app.editor.editor import Editor
from app.model.jobs import Jobs
from app.model.spaces import screen_from_canvas
from app.tools.all import TOOLS
from app.tours.samples import warp_sample
from app.tours.steps import TOURS
from assets import asset
from core.document.document import pixels_from_places
from tests.gui.conftest import endless
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


@pytest.fixture
def editor() -> Iterator[Editor]:
    jobs = Jobs()
    yield Editor(warp_sample(), TOOLS, jobs=jobs, exporter=endless)
    jobs.close()


def at_step(window: WindowDriver, number: int) -> None:
    """Wait until the tour has come to step `number`, and see that it waits there."""
    tour = window.shell.workspace.tour
    window.wait_until(lambda: tour.step >= number).wait(5)
    assert tour.step == number


def test_every_tour_has_at_most_six_steps() -> None:
    assert {mode: len(steps) <= 6 for mode, steps in TOURS.items()} == dict.fromkeys(
        ("warp", "retexture", "overlay"), True
    )


def test_the_tour_of_warp(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        window.context.set_ref("##MainMenuBar")
        window.context.menu_click("Help/Tours/###help.tour.warp")
        window.context.set_ref("")
        window.wait(6)
        at_step(window, 0)
        window.screenshot(tmp_path / "tour.png")
        window.item("//Warp/**/Arc").wait(3)
        at_step(window, 0)
        window.item("//Warp/**/Arch")
        at_step(window, 1)
        window.move(300, 300).context.key_down(imgui.Key.backslash)
        at_step(window, 2)
        window.context.key_up(imgui.Key.backslash)
        window.context.item_input_value("//Warp/Bend/##number", 30.0)
        at_step(window, 3)
        window.move(300, 300).key(imgui.Key.b).drag((300, 300), (340, 300))
        at_step(window, 4)
        window.key(imgui.Key.p).click(400, 300).drag((400, 300), (420, 310), (440, 320))
        at_step(window, 5)
        window.key(imgui.Key.mod_ctrl, imgui.Key.e)
        at_step(window, 6)
        window.key(imgui.Key.escape).wait(3)
        window.item("//##tour/Done").wait(2)
        assert window.shell.workspace.tour.mode is None

    drive(editor, script)


def test_the_tour_of_retexture(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("help.tour.retexture", editor)
        window.wait(8)
        at_step(window, 0)
        curve = editor.document.feature_curves[0]
        places = screen_from_canvas(editor.session.view, pixels_from_places(editor.document.size_px, curve.source[::3]))
        x, y = places[len(places) // 2].tolist()
        window.move(300, 300).key(imgui.Key.c).click(x, y)
        at_step(window, 1)
        window.drag((x, y), (x + 10, y + 12), (x + 20, y + 25))
        window.wait_until(lambda: window.shell.workspace.tour.step >= 3)
        window.key(imgui.Key._2)
        at_step(window, 4)
        window.key(imgui.Key._3)
        at_step(window, 5)
        window.item("//##tour/Leave the tour").wait(2)
        assert window.shell.workspace.tour.mode is None

    drive(editor, script)


@pytest.mark.slow
def test_the_tour_of_overlay(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("help.tour.overlay", editor)
        window.wait(8)
        at_step(window, 0)
        window.item("//Overlay/Find pattern")
        window.wait_until(lambda: window.shell.workspace.tour.step == 2, frames=20000)
        dropped.take(editor, asset("balloons.png"))
        at_step(window, 3)
        low, high = np.array(editor.session.view.size) * 0.45, np.array(editor.session.view.size) * 0.55
        window.drag((low[0], low[1]), (high[0], high[1]))
        at_step(window, 4)
        window.key(imgui.Key._5)
        at_step(window, 5)
        window.key(imgui.Key._1)
        at_step(window, 6)

    drive(editor, script)


def test_opening_something_else_ends_the_tour(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("help.tour.warp", editor)
        window.wait(6)
        editor.replace_document(warp_sample(), project=None, source=None)
        window.wait(3)
        assert window.shell.workspace.tour.mode is None

    drive(editor, script)
