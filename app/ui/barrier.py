"""The one place where a fault of the program ends while it draws, hears an event or runs an action.

Each part of a frame is run inside the barrier. A fault there costs that part of that frame: Dear ImGui's stacks are
taken back to where they were, the gesture in progress is given up without a trace, unsaved work is kept at once, and
the artist is told, with a way back (Undo) and a way to pass it on (Report). The editor goes on.
"""

import contextlib
import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from imgui_bundle import imgui

from app.editor.editor import Editor
from app.ui.fault_reports import place_of, report_of
from core.arrays import WeftError

T = TypeVar("T")
log = logging.getLogger("weft")

GONE_FRAMES = 120
"""A fault that has not come up for so many frames is told again."""
MOST_KNOWN = 100
"""So many different faults are remembered."""


@dataclass(frozen=True)
class Fault:
    """A fault that was caught."""

    part: str
    """What was being done: "draw the toolbar"."""
    text: str
    """The fault itself, in one line."""
    report: str
    """All that is known of it."""


class FaultBarrier:
    """Runs the parts of a frame and catches what goes wrong in them."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self.faults: list[Fault] = []
        """Each fault of the program once, the oldest first."""
        self.shown: Fault | None = None
        """What the artist is being told of."""
        self.frame = 0
        """Number of the frame that is being drawn."""
        self._last_seen: dict[str, int] = {}
        """By place in the program, the frame in which a fault came up last."""
        editor.take_fault = lambda error: self._tell("work in the background", error)

    def run(self, part: str, work: Callable[[], T]) -> T | None:
        """Return what `work` returns, None where it fails; for what draws nothing, also outside of a frame."""
        try:
            return work()
        except Exception as error:  # noqa: BLE001  this is the place where every fault ends
            self._take(part, error)
            return None

    def draw(self, part: str, work: Callable[[], T], *, failed: Callable[[], None] = lambda: None) -> T | None:
        """Do as `run` does for what draws with Dear ImGui: what it has opened when it fails is closed.

        `failed` is called then, to give up what would fail in the next frame, too.
        """
        state = imgui.internal.ErrorRecoveryState()
        imgui.internal.error_recovery_store_state(state)
        window = imgui.internal.get_current_window_read()
        try:
            return work()
        except Exception as error:  # noqa: BLE001  as above
            _recover(state, window)
            self._take(part, error)
            failed()
            return None

    def drawing(self, part: str, work: Callable[[], None]) -> Callable[[], None]:
        """Return `work` inside the barrier, to be called by Hello ImGui."""
        return lambda: self.draw(part, work)

    def _take(self, part: str, error: Exception) -> None:
        """Give up what is in progress, and tell of the fault."""
        with contextlib.suppress(Exception):
            self._editor.cancel()
        self._tell(part, error)

    def _tell(self, part: str, error: Exception) -> None:
        """Tell of a fault unless it comes up frame after frame."""
        place = f"{part} {place_of(error)}"
        is_new = self.frame - self._last_seen.get(place, -GONE_FRAMES) >= GONE_FRAMES
        if len(self._last_seen) < MOST_KNOWN or place in self._last_seen:
            self._last_seen[place] = self.frame
        if not is_new:
            return
        if isinstance(error, WeftError):
            self._editor.fail(error)
            return
        log.error("a fault: %s", part, exc_info=error)
        text = " ".join(str(error).split()) or type(error).__name__
        fault = Fault(part, text, report_of(part, error, self._editor))
        self.faults = [*self.faults, fault][-MOST_KNOWN:]
        self.shown = fault
        if self._editor.recovery is not None:
            self._editor.recovery.hurry()


def _recover(state: imgui.internal.ErrorRecoveryState, window: imgui.internal.Window) -> None:
    """Close the windows, groups and styles that were opened in `window` since `state`, and say nothing of them."""
    io = imgui.get_io()
    # Dear ImGui would also end a menu bar that was begun before; whoever began it will end it.
    in_bar, window.dc.menu_bar_appending = window.dc.menu_bar_appending, False
    logs, io.config_error_recovery_enable_debug_log = io.config_error_recovery_enable_debug_log, False
    asserts, io.config_error_recovery_enable_assert = io.config_error_recovery_enable_assert, False
    tells, io.config_error_recovery_enable_tooltip = io.config_error_recovery_enable_tooltip, False
    try:
        imgui.internal.error_recovery_try_to_recover_state(state)
    finally:
        window.dc.menu_bar_appending = in_bar
        io.config_error_recovery_enable_debug_log = logs
        io.config_error_recovery_enable_assert = asserts
        io.config_error_recovery_enable_tooltip = tells
