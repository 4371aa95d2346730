"""What the canvas shows of the picture and its handles."""

from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui

from app.editor.editor import Editor
from app.model.spaces import screen_from_canvas
from core.arrays import Bytes, Points
from core.document.document import Pin, pixels_from_places
from core.document.map import outline_of
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


def are_in_sight(editor: Editor, points: Points) -> bool:
    """Return whether all canvas positions (n, 2) are in the window."""
    view = editor.session.view
    places = screen_from_canvas(view, points)
    return bool((places >= 0).all() and (places <= view.size).all())


def test_picture_and_handles_stay_in_sight_whatever_warps_them(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.key(imgui.Key.o).wait(2)
        for name in ("Arch", "Arc", "Shell Upper", "Twist"):
            window.item(f"//Warp/**/{name}").wait(3).wait_until(lambda: editor.live.is_settled).wait(3)
            assert are_in_sight(editor, editor.map.warped.reshape(-1, 2)), name
            ring = outline_of(editor.document).ring
            assert are_in_sight(editor, pixels_from_places(editor.document.canvas_px, ring)), name
        editor.edit("Wide", editor.document.with_warp(aspect=(3.0, 1.0)))
        window.wait(4)
        assert are_in_sight(editor, np.array([[-0.5, -0.5], [1799.5, 399.5]]))
        editor.edit("Pin", editor.document.changed(pins=(Pin((0.5, 0.5), (1.8, 2.5)),)))
        window.wait(4)
        assert are_in_sight(editor, pixels_from_places((1800, 400), np.array([[1.8, 2.5]])))

    drive(editor, script)


def test_the_picture_is_as_large_as_before_when_a_preset_is_taken_back(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.wait(4)
        zoom = editor.session.view.zoom
        window.item("//Warp/**/Arc").wait(6)
        assert editor.session.view.zoom < 0.9 * zoom
        window.item("//Warp/**/None").wait(6)
        assert editor.session.view.zoom == pytest.approx(zoom)

    drive(editor, script)


def test_a_part_that_was_chosen_stays(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.move(400, 300).context.mouse_wheel_y(5)
        window.wait(3)
        view = editor.session.view
        window.item("//Warp/**/Arch").wait(6)
        assert editor.session.view == view

    drive(editor, script)


def test_handles_and_their_reach_grow_with_the_text_and_the_picture_does_not(editor: Editor, tmp_path: Path) -> None:
    marked: list[int] = []

    def script(window: WindowDriver) -> None:
        def sees(name: str) -> Bytes:
            editor.show(tool="pins", pointer=None)
            bare = window.wait(3).screenshot(tmp_path / f"{name}_bare.png").astype(int)
            editor.edit("Pin", editor.document.changed(pins=(Pin((0.5, 0.5), (0.5, 0.5)),)))
            window.wait(3).wait_until(lambda: editor.live.is_settled)
            shot = window.wait(3).screenshot(tmp_path / f"{name}.png")
            box = window.shell.workspace.canvas.area
            changed = (np.abs(shot.astype(int) - bare).max(axis=2) > 20)[round(box.y) :, : round(box.x + box.width)]
            marked.append(int(changed.sum()))
            editor.edit("None", editor.document.changed(pins=()))
            return shot

        def zoom() -> str:
            return next(text for text, tip, _ in window.shell.workspace.status_bar.figures() if tip.startswith("Zoom"))

        window.move(5, 5).shell.workspace.table.run("view.actual", editor)
        sees("plain")
        assert zoom() == "100%"
        editor.prefer(editor.preferences.changed(scale=2.0))
        window.wait(6).shell.workspace.table.run("view.actual", editor)
        window.wait(3)
        assert editor.session.view.unit == pytest.approx(2.0)
        assert zoom() == "100%"
        shot = sees("large")
        area, view = window.shell.workspace.canvas.area, editor.session.view
        pixels = editor.document.image.pixels[250:310, 100:160]
        left, top = area.in_window(*screen_from_canvas(view, np.array([100.0, 250.0])).tolist())
        seen = shot[int(top) : int(top) + 60, int(left) : int(left) + 60]
        assert np.abs(seen.astype(int) - pixels).mean() < 3, "a pixel of the picture is a pixel of the window"
        editor.edit("Pin", editor.document.changed(pins=(Pin((0.5, 0.5), (0.5, 0.5)),)))
        window.wait(3)
        x, y = area.in_window(*screen_from_canvas(view, pixels_from_places((600, 400), np.array([[0.5, 0.5]])))[0])
        window.context.mouse_move_to_pos(ImVec2(x + 15, y))
        window.context.mouse_down(0)
        window.context.mouse_move_to_pos(ImVec2(x + 55, y + 20))
        window.context.mouse_up(0)
        window.wait(4)

    drive(editor, script)
    assert marked[1] > 2.5 * marked[0] > 0
    (pin,) = editor.document.pins
    assert np.multiply(np.subtract(pin.to, 0.5), (600, 400)) == pytest.approx((40, 20), abs=0.6)
