"""Painting in the window: on the picture as it was, and on both sides of a split view."""

from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from core.arrays import Bytes
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


def redness(pixels: Bytes, window: WindowDriver, x: float, y: float) -> float:
    """Return how much redder than green it is around a place of the canvas."""
    area = window.shell.workspace.canvas.area
    left, top = round(area.x + x), round(area.y + y)
    part = pixels[top - 4 : top + 5, left - 4 : left + 5].astype(float)
    return float((part[..., 0] - part[..., 1]).mean())


def test_a_stroke_lies_under_the_brush_while_the_picture_is_warped(editor: Editor, tmp_path: Path) -> None:
    shots: list[Bytes] = []

    def script(window: WindowDriver) -> None:
        window.item("//Warp/**/Arch").wait(4)
        assert editor.session.tool == "brush"
        before = editor.session.view
        area = window.shell.workspace.canvas.area
        x, y = area.width / 2, area.height * 0.55
        window.press(x, y).move(x + 40, y).move(x + 80, y).wait(4)
        assert editor.unwarped.is_shown
        window.release().move(x + 200, y + 150)
        shots.append(window.screenshot(tmp_path / "painted.png"))
        plain = redness(shots[0], window, x + 40, y + 90)
        assert redness(shots[0], window, x + 40, y) > plain + 40
        window.key(imgui.Key.j).wait(3)
        assert not editor.unwarped.is_shown
        assert editor.session.view == before
        window.key(imgui.Key.j).wait(3)
        assert editor.unwarped.is_shown
        window.item("//Warp/**/Twist").wait(4)
        assert not editor.unwarped.is_shown

    drive(editor, script)
    assert editor.history.labels[-2:] == ("Paint mask", "Preset Twist")


def test_a_split_view_shows_the_mask_on_both_sides_and_takes_strokes_on_either(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        window.item("//Warp/**/Arch").wait(4)
        window.shell.workspace.table.run("view.split", editor)
        area, view = window.shell.workspace.canvas.area, editor.session.view
        x, y = area.width / 2 - 60, area.height / 2
        window.drag((x, y), (x - 60, y)).move(5, 5).wait(4)
        place = np.rint((np.array([x - 30, y]) - view.pan) / view.zoom).astype(int)
        assert editor.document.mask.array[place[1], place[0]] == 255
        pixels = window.screenshot(tmp_path / "split.png")
        assert redness(pixels, window, x - 30, y) > redness(pixels, window, x - 30, y + 90) + 40
        right = area.width / 2 + 60
        there = editor.map.mesh.image_from_canvas((np.array([[right, y]]) - view.pan) / view.zoom)[0]
        window.click(right, y).move(5, 5).wait(4)
        column, row = np.rint(there).astype(int)
        assert editor.document.mask.array[row, column] == 255

    drive(editor, script)
