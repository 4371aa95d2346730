"""The timeline of a drag in the real window: one answer a frame, however many events arrive."""

import pytest

from app.editor.editor import Editor
from core import tracing
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


def test_a_dragged_pin_is_answered_once_a_frame(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        editor.choose_tool("pins")
        window.click(300, 200).click(500, 300).wait(4)
        tracing.start()
        window.press(300, 200)
        for step in range(12):
            window.move(300 + 6 * step, 200 + 3 * step)
        window.release().wait(2)

    drive(editor, script)
    spans = sorted(tracing.events(), key=lambda event: float(str(event["ts"])))
    frames = [event for event in spans if event["name"] == "frame"]
    answers = [event for event in spans if event["name"] == "answer" and event["args"] == {"settled": False}]
    assert len(answers) >= 10
    for frame in frames:
        start, end = _times(frame)
        assert sum(start <= _times(answer)[0] < end for answer in answers) <= 1
    assert {"event", "rhs", "solve", "upload", "draw", "frame"} <= {str(event["name"]) for event in spans}


def _times(event: dict[str, object]) -> tuple[float, float]:
    start = float(str(event["ts"]))
    return start, start + float(str(event["dur"]))
