"""What the canvas shows of the picture and its handles."""

import numpy as np
import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from app.model.spaces import screen_from_canvas
from core.arrays import Points
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


def test_a_part_that_was_chosen_stays(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.move(400, 300).context.mouse_wheel_y(5)
        window.wait(3)
        view = editor.session.view
        window.item("//Warp/**/Arch").wait(6)
        assert editor.session.view == view

    drive(editor, script)
