"""A lost OpenGL context: the window opens again on the same work, and says so."""

from pathlib import Path

import pytest

from app.commands.edit import editor_on
from app.model.jobs import Jobs
from app.window import context_loss, shell
from app.window.context_loss import NO_ERROR, Status
from tests.app.driver import document

RESET = 0x8253
"""GL_GUILTY_CONTEXT_RESET."""
FRAMES = 12


@pytest.mark.gui
def test_window_opens_again_on_the_same_work_when_the_context_is_lost(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    before = document()
    editor = editor_on(before, None, Jobs(wake=shell.wake))
    windows: list[int] = []
    told: list[str] = []
    monkeypatch.setattr(editor, "notify", told.append)

    def reset_status() -> Status:
        """Lose the first window's context after some frames, and close the second window then."""
        number, frames = len(windows), iter(range(FRAMES))
        windows.append(len(told))

        def status() -> int:
            shell.wake()
            if next(frames, None) is not None:
                return NO_ERROR
            editor.is_closing = number > 0
            return NO_ERROR if number else RESET

        return status

    monkeypatch.setattr(context_loss, "reset_status", reset_status)
    shell.show(editor)
    assert editor.document is before
    assert windows == [0, 1]
    assert "graphics driver was reset" in told[0]


@pytest.mark.gui
def test_status_of_a_window_that_is_well_is_no_error(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    editor = editor_on(document(), None, Jobs(wake=shell.wake))
    asked = context_loss.reset_status
    found: list[int] = []

    def reset_status() -> Status:
        ask = asked()

        def status() -> int:
            shell.wake()
            found.append(ask())
            editor.is_closing = len(found) >= FRAMES
            return found[-1]

        return status

    monkeypatch.setattr(context_loss, "reset_status", reset_status)
    shell.show(editor)
    assert found == [NO_ERROR] * len(found)
