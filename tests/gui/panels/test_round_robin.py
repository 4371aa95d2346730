"""While a button is held the panels are laid out in turn, and those that wait are shown as they were."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from app.editor.editor import Editor
from app.ui.options_bar import OptionsBar
from app.ui.panels.handles import HandlesPanel
from app.ui.panels.warp import WarpPanel
from app.ui.status_bar import StatusBar
from app.ui.widgets.fallback_fonts import FallbackFonts
from core.document.document import Pin
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui

Parts = type[WarpPanel] | type[HandlesPanel] | type[OptionsBar] | type[StatusBar]
PARTS: tuple[Parts, ...] = (WarpPanel, HandlesPanel, OptionsBar, StatusBar)
TURNS = 5
"""The parts, and the toolbar."""


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> Counter[Parts]:
    """How often each part was laid out."""
    counts: Counter[Parts] = Counter()

    def counting(part: Parts) -> Callable[[object], None]:
        draw = part.draw

        def count(self: object) -> None:
            counts[part] += 1
            draw(self)  # type: ignore[arg-type]  # each is called with its own

        return count

    for part in PARTS:
        monkeypatch.setattr(part, "draw", counting(part))
    return counts


def with_pin(editor: Editor) -> None:
    editor.edit("Pin", editor.document.with_warp(preset="arc", bend=20.0).changed(pins=(Pin((0.5, 0.5), (0.5, 0.5)),)))
    editor.choose_tool("pins")


def middle(window: WindowDriver) -> tuple[float, float]:
    width, height = window.shell.workspace.canvas.area.size
    return width / 2, height / 2


def test_each_panel_waits_for_its_turn_in_a_drag_and_shows_what_it_did(
    editor: Editor, drawn: Counter[Parts], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_pin(editor)
    looked: list[FallbackFonts] = []

    def look(fonts: FallbackFonts) -> None:
        looked.append(fonts)

    monkeypatch.setattr(FallbackFonts, "look", look)

    def script(window: WindowDriver) -> None:
        x, y = middle(window.wait(40))  # until the small pictures of the presets are drawn
        before = window.screenshot(tmp_path / "before.png")
        window.press(x, y).wait(3)
        drawn.clear()
        looked.clear()
        frame = window.shell.frames
        for step in range(6):
            window.move(x + 4 * step, y)
        frames = window.shell.frames - frame
        assert frames >= 2 * TURNS
        for part in PARTS:
            assert abs(drawn[part] - frames / TURNS) <= 1, part
        assert not looked
        during = window.screenshot(tmp_path / "during.png")
        area = window.shell.workspace.canvas.area
        panel = slice(0, int(area.height / 2)), slice(int(area.x + area.width) + 8, None)
        assert np.ptp(before[panel].astype(int)) > 100
        assert np.abs(before[panel].astype(int) - during[panel]).max() <= 1
        drawn.clear()
        frame = window.shell.frames
        window.release().wait(4)
        for part in PARTS:
            assert drawn[part] >= window.shell.frames - frame - 1
        assert looked

    drive(editor, script)


def test_what_a_waiting_panel_shows_follows_the_drag(editor: Editor, tmp_path: Path) -> None:
    with_pin(editor)

    def script(window: WindowDriver) -> None:
        x, y = middle(window.wait(4))
        window.press(x, y).move(x + 10, y).wait(2 * TURNS)
        near = window.screenshot(tmp_path / "near.png")
        window.move(x + 80, y).wait(2 * TURNS)
        far = window.screenshot(tmp_path / "far.png")
        window.release()
        area = window.shell.workspace.canvas.area
        panel = slice(int(area.y + area.height * 0.6), int(area.y + area.height)), slice(int(area.x + area.width), None)
        assert (near[panel] != far[panel]).any()

    drive(editor, script)


def test_panels_that_come_in_a_drag_are_laid_out(editor: Editor, drawn: Counter[Parts]) -> None:
    with_pin(editor)
    editor.show(panels=False)

    def script(window: WindowDriver) -> None:
        x, y = middle(window.wait(4))
        window.press(x, y).wait(3)
        assert not drawn[WarpPanel]
        editor.show(panels=True)
        window.move(x + 10, y).wait(3 * TURNS)
        assert drawn[WarpPanel] >= 2
        window.release()

    drive(editor, script)


def test_the_panel_whose_slider_is_held_is_laid_out_in_every_frame(editor: Editor, drawn: Counter[Parts]) -> None:
    with_pin(editor)

    def script(window: WindowDriver) -> None:
        window.wait(4).context.mouse_move("//Warp/Bend/##track")
        window.context.mouse_down(0)
        window.wait(3)
        drawn.clear()
        frame = window.shell.frames
        window.wait(3 * TURNS)
        frames = window.shell.frames - frame
        assert drawn[WarpPanel] == frames
        assert abs(drawn[HandlesPanel] - frames / TURNS) <= 1
        window.release()

    drive(editor, script)
