"""Drives the window as a user would; positions are pixels of the canvas, as in `app.model.events`."""

from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from imgui_bundle import ImVec2, hello_imgui, imgui
from imgui_bundle.immapp import testing

from app.editor.editor import Editor
from app.window.shell import Shell
from core.arrays import Bytes

Context = imgui.test_engine.TestContext

PATIENCE_S = 3600.0
"""The test engine gives up on a script after so long."""
FRAME_S = 1 / 60
"""Dear ImGui takes frames to be so far apart: two clicks are a double click however long drawing takes."""


class WindowDriver:
    """The window that is open, and the test engine's mouse and keyboard."""

    def __init__(self, shell: Shell, context: Context) -> None:
        self.shell = shell
        self.editor = shell.editor
        self.context = context

    def wait(self, frames: int = 2) -> "WindowDriver":
        """Let some frames pass."""
        self.context.yield_(frames)
        return self

    def wait_until(self, done: Callable[[], bool], *, frames: int = 2000) -> "WindowDriver":
        """Let frames pass until `done`; fail after so many."""
        for _ in range(frames):
            if done():
                return self
            if self.context.is_error():
                break
            self.context.yield_(1)
        raise AssertionError("it never came")

    @property
    def dialog(self) -> str | None:
        """Title of the open dialog."""
        return self.shell.workspace.dialogs.title

    def place(self, x: float, y: float) -> ImVec2:
        """Return the place in the window of a place on the canvas, in its screen pixels."""
        return ImVec2(*self.shell.workspace.canvas.area.in_window(x, y))

    def move(self, x: float, y: float) -> "WindowDriver":
        self.context.mouse_move_to_pos(self.place(x, y))
        return self

    def press(self, x: float, y: float, button: int = 0) -> "WindowDriver":
        self.move(x, y).context.mouse_down(button)
        return self

    def release(self, button: int = 0) -> "WindowDriver":
        self.context.mouse_up(button)
        return self

    def drag(self, *places: tuple[float, float], button: int = 0) -> "WindowDriver":
        """Press at the first place, move over the others and let go."""
        self.press(*places[0], button)
        for place in places[1:]:
            self.move(*place)
        return self.release(button)

    def click(self, x: float, y: float, button: int = 0) -> "WindowDriver":
        return self.drag((x, y), button=button)

    def key(self, *keys: int) -> "WindowDriver":
        """Press a key together with modifiers."""
        chord = 0
        for key in keys:
            chord |= int(key)  # the early releases of Python 3.11 cannot join the enumeration's own members
        self.context.key_press(chord)
        return self

    def item(self, path: str) -> "WindowDriver":
        """Click a widget: `//Warp/Arc`."""
        self.context.item_click(path)
        return self

    def screenshot(self, path: Path) -> Bytes:
        """Write the window, once its canvas is drawn, to `path` and return it, (H, W, 3) uint8 RGB."""
        self.wait(3).wait_until(lambda: self.shell.is_drawn)
        testing.capture(self.context, str(path))
        pixels = cv2.imread(str(path))
        assert pixels is not None
        return np.asarray(pixels[..., ::-1])


def inside(panel: str) -> imgui.internal.Window:
    """Return the window that holds a panel's widgets and scrolls them."""
    return imgui.internal.find_window_by_name(panel).dc.child_windows[0]


def _be_patient() -> None:
    """Let a script take as long as a busy machine needs: frames follow one another by a clock of their own."""
    limits = imgui.test_engine.get_io(hello_imgui.get_imgui_test_engine())
    limits.config_watchdog_warning = limits.config_watchdog_kill_test = limits.config_watchdog_kill_app = PATIENCE_S
    limits.config_fixed_delta_time = FRAME_S


def drive(
    editor: Editor,
    script: Callable[[WindowDriver], None],
    *,
    size: tuple[int, int] = (1440, 900),
    faults: Sequence[str] = (),
    keeps_settings: bool = False,
) -> Shell:
    """Open a window of `size` on `editor`, run `script` in it and close it again.

    Fails unless exactly the `faults` came up in it, which the window has caught.
    """
    shell = Shell(editor, keeps_settings=keeps_settings)
    shell.params.app_window_params.window_geometry.size = size
    shell.params.callbacks.register_tests = _be_patient
    try:
        testing.run(test_function=lambda context: script(WindowDriver(shell, context)), runner_params=shell.params)
    except RuntimeError:
        if not editor.is_closing:  # a script that closes the window is cut off there
            raise
    caught = shell.workspace.barrier.faults
    assert [fault.text for fault in caught] == list(faults), "\n".join(fault.report for fault in caught)
    return shell
