"""Files that are dragged onto the window from another program."""

from pathlib import Path
from threading import Thread

import glfw
import pytest
from imgui_bundle import glfw_utils

from app.editor.editor import Editor
from core.imaging.images import save
from tests.gui.window_driver import WindowDriver, drive
from tests.gui.x11_drop import Source

pytestmark = pytest.mark.gui


def test_the_first_of_the_files_that_are_let_go_over_the_window_opens(editor: Editor, tmp_path: Path) -> None:
    paths = [tmp_path / "a fine picture, 100 %.png", tmp_path / "another.png"]
    for path, height in zip(paths, (100, 50), strict=True):
        save(editor.document.image.with_pixels(editor.document.image.pixels[:height]), path)
    taken: list[bool] = []

    def script(window: WindowDriver) -> None:
        if glfw.get_platform() != glfw.PLATFORM_X11:
            pytest.skip("this is no X11 window")
        source = Source(paths)
        target = glfw.get_x11_window(glfw_utils.glfw_window_hello_imgui())
        thread = Thread(target=lambda: taken.append(source.drop(target, 300, 300)), daemon=True)
        thread.start()
        window.wait_until(lambda: not thread.is_alive()).wait_until(lambda: editor.name == paths[0].name)
        source.close()

    drive(editor, script)
    assert taken == [True]
    assert editor.document.size_px == (600, 100)
    assert editor.source_path == paths[0]
