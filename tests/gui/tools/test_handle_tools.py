"""The outline, pins with their ring, inner curves, hand and magnifier, by mouse and keys in the window."""

from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from app.model.spaces import screen_from_canvas
from app.tools.outline import ring_on_screen
from app.tools.pins import targets_on_screen
from tests.gui.window.test_small_windows import bar
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui
Place = tuple[float, float]


def on_screen(editor: Editor, x: float, y: float) -> Place:
    """Return where a pixel of the result is on the canvas."""
    found = screen_from_canvas(editor.session.view, np.array([[x, y]]))[0]
    return float(found[0]), float(found[1])


def corner(editor: Editor, number: int) -> Place:
    """Return where a corner of the outline is on the canvas."""
    found = ring_on_screen(editor)[3 * number]
    return float(found[0]), float(found[1])


def pin(editor: Editor, number: int) -> Place:
    """Return where a pin is on the canvas."""
    found = targets_on_screen(editor)[number]
    return float(found[0]), float(found[1])


def aside(start: Place, x: float, y: float) -> Place:
    """Return a place beside another."""
    return start[0] + x, start[1] + y


def settle(window: WindowDriver) -> None:
    editor = window.editor
    window.wait(3).wait_until(lambda: editor.jobs.is_idle and editor.live.is_settled).wait(2)


def test_corners_of_the_outline_go_in_alike_snap_and_show_to_what(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        window.move(5, 5).key(imgui.Key.o).wait(3)
        start = corner(editor, 0)
        window.drag(start, aside(start, 20, 20), aside(start, 60, 40)).wait(3)
        window.item(f"//{bar('##Top')}/###handles.mirror_across").wait(2)
        assert editor.session.outline.across
        start = corner(editor, 3)
        window.press(*start).move(*aside(start, 30, -30)).move(*aside(start, 58, -60)).wait(2)
        guide = {tuple(np.round(line[1] - line[0])) for line in editor.session.guides}
        assert len(guide) == 1
        shot = window.screenshot(tmp_path / "guide.png")
        x = round(corner(editor, 0)[0] + window.shell.workspace.canvas.area.x)
        y = round(corner(editor, 0)[1] + window.shell.workspace.canvas.area.y)
        assert np.ptp(shot[y + 40 : y + 200, x - 2 : x + 3].max(axis=(1, 2)).astype(int)) > 40, "a dashed line"
        window.release().wait(3)
        settle(window)

    drive(editor, script)
    ring = ring_on_screen(editor)
    assert ring[9, 0] == pytest.approx(ring[0, 0], abs=0.01), "plumb under the corner above"
    low, high = ring[[9, 6]]
    width = ring[3, 0] - ring[0, 0] + 60
    assert high[0] == pytest.approx(low[0] + width - 120, abs=1.5), "the opposite one as far in"
    assert high[1] == pytest.approx(low[1], abs=0.01)
    assert editor.history.labels[1:] == ("Move corner", "Move corner")


def test_a_pin_is_turned_by_its_ring_and_two_are_moved_by_their_box(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        window.move(5, 5).key(imgui.Key.p).wait(2)
        window.click(*on_screen(editor, 200, 200)).wait(40).click(*on_screen(editor, 400, 200)).wait(40)
        knob = aside(pin(editor, 1), 0, -34)
        window.drag(knob, aside(knob, 20, 4), aside(pin(editor, 1), 34, 0)).wait(3)
        ring = editor.document.pins[1].ring
        assert ring is not None
        assert ring.turn_deg == pytest.approx(90, abs=3)
        window.screenshot(tmp_path / "ring.png")
        window.key(imgui.Key.mod_ctrl, imgui.Key.z).key(imgui.Key.mod_ctrl, imgui.Key.a).wait(2)
        assert editor.session.selected == {0, 1}
        middle = on_screen(editor, 300, 200)
        window.drag(middle, aside(middle, 0, 10), aside(middle, 0, 25))
        window.key(imgui.Key.down_arrow)
        settle(window)

    drive(editor, script)
    moved = [np.subtract(p.to, p.at) * editor.canvas_px for p in editor.document.pins]
    assert np.allclose(moved[0], moved[1], atol=1e-6)
    assert moved[0][1] > 10
    assert editor.map.result is not None
    assert not editor.map.result.missed_pins


def test_how_far_a_pin_is_stiff_is_typed_and_holds_while_it_is_dragged(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        window.move(5, 5).key(imgui.Key.p).wait(2)
        for x, y in ((100, 200), (300, 200)):
            window.click(*on_screen(editor, x, y)).wait(40)
        window.context.item_input_value("//Handles/##Stiff within", 60.0)
        window.wait(3)
        assert editor.document.pins[1].stiff == pytest.approx(60 / np.hypot(600, 400))
        start = pin(editor, 1)
        window.press(*start).move(*aside(start, 30, -60)).move(*aside(start, 60, -120)).wait(2)
        live = editor.map.result
        assert live is not None
        assert max(feature.residual for feature in live.features) < 1e-6
        window.release()
        settle(window)
        window.screenshot(tmp_path / "stiff.png")

    drive(editor, script)
    result = editor.map.result
    assert result is not None
    (disc,) = result.features
    assert disc.nodes > 20
    assert disc.residual < 1e-6
    assert not result.missed_pins
    assert not result.folded.any()
    assert editor.history.labels[1:] == ("Add pin", "Add pin", "Stiff pin", "Move pin")


def test_an_inner_curve_is_drawn_and_takes_the_picture_along(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.move(5, 5).key(imgui.Key.c).wait(2)
        for x in (150, 300, 450):
            window.click(*on_screen(editor, x, 200)).wait(40)
        window.key(imgui.Key.enter).wait(3)
        assert len(editor.document.curves) == 1
        start = on_screen(editor, 225, 200)
        window.drag(start, aside(start, 0, 15), aside(start, 0, 40)).wait(2)
        settle(window)

    drive(editor, script)
    (pair,) = editor.document.curves
    assert np.abs(pair.target - pair.source).max() > 0.05
    result = editor.map.result
    assert result is not None
    assert np.abs(result.warped - result.grid.nodes).max() > 20


def test_the_hand_moves_the_view_and_the_magnifier_zooms_in_and_out(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.move(5, 5).key(imgui.Key.h).wait(2)
        before = editor.session.view
        window.drag((300, 300), (320, 310), (340, 330)).wait(2)
        assert np.subtract(editor.session.view.pan, before.pan) == pytest.approx((40, 30))
        window.key(imgui.Key.z).wait(2)
        under = on_screen(editor, 200, 150)
        window.click(*under).wait(40)
        assert editor.session.view.zoom > before.zoom
        assert on_screen(editor, 200, 150) == pytest.approx(under, abs=1)
        window.context.key_down(imgui.Key.mod_alt)
        window.click(*under)
        window.context.key_up(imgui.Key.mod_alt)
        window.wait(3)
        assert editor.session.view.zoom == pytest.approx(before.zoom)

    drive(editor, script)
    assert editor.history.index == 0
