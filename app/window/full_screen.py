"""The whole screen for the window, and back to where it was."""

from typing import Any

import glfw


class FullScreen:
    """Knows where a window was before it took the whole screen."""

    def __init__(self, window: Any) -> None:
        self._window = window
        self._before: tuple[int, int, int, int] | None = None
        """Place and size of the window then; None while it does not have the whole screen."""

    def toggle(self) -> None:
        """Give the window the whole screen that its middle is on, or its former place and size."""
        if self._before is not None:
            no_monitor: Any = None
            glfw.set_window_monitor(self._window, no_monitor, *self._before, glfw.DONT_CARE)
            self._before = None
            return
        x, y = glfw.get_window_pos(self._window)
        width, height = glfw.get_window_size(self._window)
        monitor = _monitor_at(x + width // 2, y + height // 2)
        if monitor is not None:
            mode = glfw.get_video_mode(monitor)
            self._before = x, y, width, height
            glfw.set_window_monitor(self._window, monitor, 0, 0, *mode.size, mode.refresh_rate)


def _monitor_at(x: int, y: int) -> Any:
    """Return the monitor that shows a place, or else the first; None where there is none."""
    monitors = list(glfw.get_monitors())
    for monitor in monitors:
        left, top = glfw.get_monitor_pos(monitor)
        width, height = glfw.get_video_mode(monitor).size
        if left <= x < left + width and top <= y < top + height:
            return monitor
    return monitors[0] if monitors else None
