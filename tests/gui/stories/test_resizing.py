"""Resizing: by numbers, by ratio, by dragging the frame, and with a proposal of what to keep."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.actions.view import whole
from app.editor.editor import Editor
from app.marking.resizing import is_proposal
from app.model.jobs import Jobs
from app.model.session import Resizing
from app.model.spaces import screen_from_canvas
from app.tools.all import TOOLS
from app.ui.canvas.whole_view import WholeView
from app.ui.panels.resize import RATIOS
from app.ui.widgets import theme
from core.document.document import Document
from core.imaging.images import Image
from core.rasters.raster import Raster
from tests.app.driver import EditorDriver
from tests.core.selection.test_importance import two_discs
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


@pytest.fixture
def editor() -> Iterator[Editor]:
    """Make an editor on a picture of two discs, 500 x 300 pixels."""
    jobs = Jobs()
    yield Editor(Document.of(two_discs()[0]).with_warp(cell_px=10.0), TOOLS, jobs=jobs)
    jobs.close()


def settle(window: WindowDriver) -> None:
    editor = window.editor
    window.wait(3).wait_until(lambda: editor.jobs.is_idle and editor.live.is_settled).wait(2)


def test_a_picture_of_its_own_size_is_not_given_that_size_again(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.item("//Warp/Resize##page").wait(2).item("//Warp/As the picture").wait(2)
        assert editor.history.index == 0
        window.item("//Warp/1:1").wait(2).item("//Warp/As the picture").wait(2)
        assert editor.document.canvas_px == editor.document.size_px

    drive(editor, script)


def test_numbers_ratios_and_a_proposal_that_can_be_painted_on(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        window.item("//Warp/Resize##page").wait(2)
        assert editor.session.tool == "resize"
        window.item("//Warp/1:1").wait(2)
        settle(window)
        assert editor.document.canvas_px == (300, 300)
        assert is_proposal(editor.document)
        result = editor.map.result
        assert result is not None
        assert len(result.features) == 2
        assert max(feature.residual for feature in result.features) < 1e-6
        figures = " ".join(text for text, _, _ in window.shell.workspace.status_bar.figures())
        assert "→  300 × 300 px" in figures
        window.screenshot(tmp_path / "square.png")
        window.context.item_input_value("//Warp/How much/##number", 10.0)
        window.wait(3)
        assert (editor.document.mask.array > 127).mean() == pytest.approx(0.10, abs=0.02)
        window.key(imgui.Key.b).wait(2)
        assert editor.session.page == "resize"
        area = window.shell.workspace.canvas.area
        window.drag((area.width / 2, area.height / 2), (area.width / 2 + 40, area.height / 2)).wait(2)
        assert not is_proposal(editor.document)
        window.item("//Warp/%##unit").wait(2).context.item_input_value("//Warp/##Width", 120.0)
        window.wait(3)
        assert editor.document.canvas_px == (600, 300)
        window.item("//Warp/Keep the ratio").wait(2).context.item_input_value("//Warp/##Height", 50.0)
        window.wait(3)

    drive(editor, script)
    assert editor.document.canvas_px == (300, 150)
    assert editor.history.labels[1:4] == ("Resize", "Propose what to keep", "How much to keep")


def test_the_ratio_that_the_result_has_is_lit(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        def lit() -> set[str]:
            """Return which ratios' buttons have the colour of what is on."""
            window.move(5, 5).wait(3)
            shot, on = window.screenshot(tmp_path / "lit.png"), theme.rgb(theme.ACCENT)
            wanted, names = np.rint(255 * np.array([on.x, on.y, on.z])), [name for name, _ in RATIOS]
            corners = {name: window.context.item_info(f"//Warp/{name}").rect_full.min for name in names}
            return {n for n, c in corners.items() if np.abs(shot[int(c.y) + 3, int(c.x) + 6, :3] - wanted).max() < 8}

        window.item("//Warp/Resize##page").wait(2)
        assert not lit()
        window.item("//Warp/4:5").wait(2)
        assert lit() == {"4:5"}
        window.context.item_input_value("//Warp/##Width", 217.0)
        window.wait(2)
        assert not lit()

    drive(editor, script)


def test_a_line_beside_what_is_kept_stays_straight_until_it_is_switched_off(tmp_path: Path) -> None:
    pixels = np.array(two_discs()[0].pixels)
    pixels[215:219] = 250
    jobs = Jobs()
    editor = Editor(Document.of(Image(pixels)).with_warp(cell_px=10.0), TOOLS, jobs=jobs)
    editor.edit(
        "Mask", editor.document.changed(mask=Raster.from_array(np.where(two_discs()[1], 255, 0).astype(np.uint8)))
    )
    found: list[float] = []

    def measure(window: WindowDriver) -> None:
        """Find how far the line is from straight, in pixels, where the map takes it."""
        settle(window)
        result = editor.map.result
        assert result is not None
        assert not result.folded.any()
        at = np.stack([np.linspace(10, 490, 80), np.full(80, 217.0)], axis=1)
        nodes, weights = result.grid.weights_at(at)
        there = (result.warped.reshape(-1, 2)[nodes] * weights[..., None]).sum(axis=1)
        found.append(
            float(np.abs(there[:, 1] - np.polyval(np.polyfit(there[:, 0], there[:, 1], 1), there[:, 0])).max())
        )

    def script(window: WindowDriver) -> None:
        window.item("//Warp/Resize##page").wait(2).item("//Warp/1:1").wait(2)
        measure(window)
        window.screenshot(tmp_path / "straight.png")
        window.item("//Warp/Straight lines").wait(2)
        measure(window)

    try:
        drive(editor, script)
    finally:
        jobs.close()
    straight, bent = found
    assert straight < 0.35 * bent
    assert not editor.document.warp.straight
    assert editor.history.labels[-2:] == ("Resize", "Straight lines")


def test_a_pin_lifts_a_horizon_that_stays_straight_until_that_is_switched_off(tmp_path: Path) -> None:
    pixels = np.array(two_discs()[0].pixels)
    pixels[:140] = (150, 180, 220)
    pixels[140:] = (60, 90, 40)
    jobs = Jobs()
    editor = Editor(Document.of(Image(pixels)).with_warp(cell_px=10.0, straight=True), TOOLS, jobs=jobs)
    found: list[float] = []

    def measure(window: WindowDriver) -> None:
        """Find how far the horizon is from straight, in pixels, and that the pin is met."""
        settle(window)
        result = editor.map.result
        assert result is not None
        assert not result.folded.any()
        assert result.pin_reports[0].worst_px < 0.1
        at = np.stack([np.linspace(2, 497, 80), np.full(80, 139.5)], axis=1)
        nodes, weights = result.grid.weights_at(at)
        there = (result.warped.reshape(-1, 2)[nodes] * weights[..., None]).sum(axis=1)
        found.append(
            float(np.abs(there[:, 1] - np.polyval(np.polyfit(there[:, 0], there[:, 1], 1), there[:, 0])).max())
        )

    def script(window: WindowDriver) -> None:
        window.move(5, 5).key(imgui.Key.p).wait(2)
        at, to = screen_from_canvas(editor.session.view, np.array([[250.0, 120.0], [250.0, 80.0]])).tolist()
        window.click(*at).wait(2).press(*at).move(*to).wait(2)
        assert editor.document.pins[0].to[1] < 0.3
        window.release()
        measure(window)
        window.screenshot(tmp_path / "lifted.png")
        window.item("//Warp/Straight lines").wait(2)
        measure(window)
        window.screenshot(tmp_path / "bent.png")

    try:
        drive(editor, script)
    finally:
        jobs.close()
    straight, bent = found
    assert bent > 10
    assert straight < 0.2 * bent


@pytest.mark.parametrize("side", ["right", "left", "corner"])
def test_the_frame_is_dragged(editor: Editor, side: str) -> None:
    editor.edit("Mask", editor.document.changed(mask=Raster.from_array(np.full((300, 500), 0, np.uint8))))
    editor.show(resizing=Resizing(proposes=False))

    def script(window: WindowDriver) -> None:
        window.move(5, 5).key(imgui.Key.f).wait(3)
        view = editor.session.view
        low, high = screen_from_canvas(view, np.array([[-0.5, -0.5], [499.5, 299.5]]))
        middle = (low[1] + high[1]) / 2
        by = 100 * view.zoom
        if side == "right":
            window.drag((high[0], middle), (high[0] - by / 2, middle), (high[0] - by, middle))
        elif side == "left":
            window.drag((low[0], middle), (low[0] + by / 2, middle), (low[0] + by, middle))
        else:
            window.drag((high[0], high[1]), (high[0] - by, high[1] - by / 2))
        window.wait(3)
        now = screen_from_canvas(editor.session.view, np.array([[-0.5, -0.5], np.subtract(editor.canvas_px, 0.5)]))
        fixed = now[1] if side == "left" else now[0]
        assert fixed == pytest.approx(high if side == "left" else low, abs=2.0)

    drive(editor, script)
    width, height = editor.document.canvas_px
    assert (width, height) == pytest.approx((400, 250 if side == "corner" else 300), abs=4)
    assert editor.history.labels[-1] == "Resize"


def test_a_drag_within_one_frame_leaves_the_view_too() -> None:
    hand = EditorDriver()
    hand.editor.show(view=whole(hand.editor))
    view, following = hand.editor.session.view, WholeView(hand.editor)
    for _ in range(2):
        following.update()
    width, height = hand.editor.canvas_px
    x, y = screen_from_canvas(view, np.array([width - 0.5, height - 0.5])).tolist()
    hand.tool("resize").press(x, y).move(x - 40, y - 10).release()
    assert hand.editor.canvas_px != (width, height)
    for _ in range(2):
        following.update()
    assert hand.editor.session.view == view


def test_escape_gives_a_drag_up(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.move(5, 5).key(imgui.Key.f).wait(3)
        view = editor.session.view
        x, y = screen_from_canvas(view, np.array([499.5, 149.5])).tolist()
        window.press(x, y).move(x - 60, y).move(x - 90, y)
        assert editor.document.canvas_px[0] < 480
        window.key(imgui.Key.escape).release().wait(2)
        assert editor.session.view == view

    drive(editor, script)
    assert editor.history.index == 0
    assert editor.document.canvas_px == (500, 300)


def test_a_result_of_another_size_is_shown_whole_and_as_large_as_before(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.item("//Warp/Resize##page").wait(2).item("//Warp/%##unit").wait(2)
        for width in (40.0, 150.0):
            window.context.item_input_value("//Warp/##Width", width)
            settle(window)
            assert editor.session.view == whole(editor)
        wide = editor.session.view
        right, middle = screen_from_canvas(wide, np.array([[749.5, 149.5]]))[0]
        window.drag((right, middle), (right - 150, middle))
        settle(window)
        assert editor.document.canvas_px[0] < 700
        assert editor.session.view == wide
        window.move(400, 300).context.mouse_wheel_y(5)
        window.wait(3)
        chosen = editor.session.view
        window.context.item_input_value("//Warp/##Width", 60.0)
        settle(window)
        assert editor.session.view == chosen

    drive(editor, script)


def test_what_is_said_of_a_fit_that_failed_goes_once_the_mask_is_another(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        said = window.shell.workspace.toasts
        editor.edit("All", editor.document.changed(mask=Raster.filled(*editor.document.size_px, 255)))
        for _ in range(2):
            window.shell.workspace.table.run("mask.fit", editor)
            window.wait(3).wait_until(lambda: editor.jobs.is_idle).wait(2)
        assert len(said.texts) == 1
        assert "paint" in said.texts[0]
        editor.notify("something else", "error")
        disc = np.where(two_discs()[1], 255, 0).astype(np.uint8)
        editor.edit("Paint", editor.document.changed(mask=Raster.from_array(disc)))
        window.wait(3)
        assert said.texts == ("Something else",)

    drive(editor, script)
