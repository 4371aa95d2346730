"""Resizing: by numbers, by ratio, by dragging the frame, and with a proposal of what to keep."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from app.marking.resizing import is_proposal
from app.model.jobs import Jobs
from app.model.session import Resizing
from app.model.spaces import screen_from_canvas
from app.tools.all import TOOLS
from core.document.document import Document
from core.imaging.images import Image
from core.rasters.raster import Raster
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
        assert "→ 300 × 300 px" in figures
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
