"""When the window draws its next frame: soon after input, when something is to change by itself, else not at all."""

import time
from collections.abc import Iterable

import glfw
from imgui_bundle import imgui

FRAMES_AFTER_INPUT = 3
"""Dear ImGui needs a frame or two to come to rest: hovering, layout and popups answer in the next one."""
REST_S = 0.55
"""When the pointer has rested so long, tooltips show: one more frame."""
BLINK_S = 0.3
"""How often the caret of a text field wants a frame."""


class FrameRhythm:
    """Counts the frames that are due, and sleeps in GLFW between them."""

    def __init__(self, first: int) -> None:
        self._due = first + FRAMES_AFTER_INPUT
        self._last_input = 0.0
        self._has_rested = False

    def stir(self) -> None:
        """Draw a few frames, since something was done to the window."""
        self._due, self._last_input, self._has_rested = FRAMES_AFTER_INPUT, time.monotonic(), False

    def wait(self, waits: Iterable[float | None]) -> None:
        """Sleep until there is a reason to draw: input, or the first of `waits`, in seconds, has gone by."""
        if self._due > 0:
            self._due -= 1
            return
        timeout = self._timeout(waits)
        if timeout is None:
            glfw.wait_events()
        elif timeout > 0:
            glfw.wait_events_timeout(timeout)
        self._due = FRAMES_AFTER_INPUT - 1

    def _timeout(self, waits: Iterable[float | None]) -> float | None:
        """Return seconds until something on the screen is to change by itself."""
        known = [wait for wait in waits if wait is not None]
        if not self._has_rested:
            self._has_rested = True
            known.append(max(self._last_input + REST_S - time.monotonic(), 0.0))
        if imgui.get_io().want_text_input:
            known.append(BLINK_S)
        return min(known, default=None)
