"""Onion skin, heat maps with their legend, hints in the status bar, and what stands under Advanced."""

from pathlib import Path

import numpy as np
import pytest

from app.editor.editor import Editor
from app.render.heat import measure_heat
from app.render.scene import MarkColours
from core.arrays import Bytes
from core.rasters.raster import Raster
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


def at(pixels: Bytes, window: WindowDriver, x: float, y: float) -> np.ndarray:
    """Return the mean colour around a place of the canvas."""
    area = window.shell.workspace.canvas.area
    left, top = round(area.x + x), round(area.y + y)
    return np.asarray(pixels[top - 1 : top + 2, left - 1 : left + 2].reshape(-1, 3).mean(axis=0))


def test_the_onion_skin_is_half_before_and_half_after(editor: Editor, tmp_path: Path) -> None:
    seen: dict[str, np.ndarray] = {}

    def script(window: WindowDriver) -> None:
        editor.choose_tool("hand")
        window.item("//Warp/**/Arch").wait(3).wait_until(lambda: editor.live.is_settled)
        view = editor.session.view
        x, y = np.array([205.0, 205.0]) * view.zoom + view.pan
        window.move(5, 5)
        for name in ("result", "before", "onion"):
            editor.show(compare=name)
            seen[name] = at(window.wait(3).screenshot(tmp_path / f"{name}.png"), window, x, y)

    drive(editor, script)
    assert np.abs(seen["result"] - seen["before"]).max() > 60
    assert seen["onion"] == pytest.approx((seen["result"] + seen["before"]) / 2, abs=10)


def test_heat_maps_say_what_the_map_does() -> None:
    y, x = np.mgrid[:5, :7].astype(float) * 10
    rest = np.stack([x, y], axis=-1)
    stretched = rest * (2.0, 1.0)
    assert measure_heat(rest, stretched, "scale") == pytest.approx(1.0)
    assert measure_heat(rest, stretched, "area") == pytest.approx(0.5)
    assert measure_heat(rest, stretched, "angle") == pytest.approx(0.0, abs=1e-6)
    assert measure_heat(rest, rest * (1.0, 0.25), "scale") == pytest.approx(-2.0)
    growing = [measure_heat(rest, rest * (1.5, high), "scale").mean() for high in np.arange(0.5, 1.5, 0.01)]
    assert np.abs(np.diff(growing)).max() < 0.03  # no step where what grows most is another side
    assert measure_heat(rest, rest * (1.5, 1 / 1.5), "scale") == pytest.approx(0.0, abs=1e-6)
    sheared = np.stack([x + np.tan(np.radians(15)) * y, y], axis=-1)
    assert measure_heat(rest, sheared, "angle") == pytest.approx(15 / 45)
    assert measure_heat(rest, sheared, "area") == pytest.approx(0.0, abs=1e-6)
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    for heat in ("scale", "angle", "area"):
        assert measure_heat(rest, rest @ turn.T, heat) == pytest.approx(0.0, abs=1e-6)


def test_a_heat_map_has_a_legend_and_there_is_one_at_a_time(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        window.item("//Warp/**/Twist").wait(3).wait_until(lambda: editor.live.is_settled)
        area = window.shell.workspace.canvas.area
        table = window.shell.workspace.table
        plain = window.move(5, 5).wait(3).screenshot(tmp_path / "plain.png")
        corner = np.s_[round(area.y + area.height) - 80 : round(area.y + area.height), round(area.x) + 10 :][0:1]
        for name in ("scale", "angle", "area"):
            table.run(f"view.overlay.{name}", editor)
            assert editor.session.overlays.heat == name
            pixels = window.wait(3).screenshot(tmp_path / f"heat_{name}.png")
            assert (pixels[corner] != plain[corner]).any()
            grown = (np.array(MarkColours().grown[:3]) * 255).astype(int)
            strip = pixels[corner][:, : round(area.x) + 260].reshape(-1, 3).astype(int)
            assert np.abs(strip - grown).max(axis=1).min() < 30
        table.run("view.overlay.area", editor)
        assert editor.session.overlays.heat is None

    drive(editor, script)


def test_the_status_bar_says_what_is_under_the_mouse(editor: Editor) -> None:
    mask = np.zeros((400, 600), np.uint8)
    mask[150:250, 200:400] = 255

    def script(window: WindowDriver) -> None:
        editor.edit("Mask", editor.document.changed(mask=Raster.from_array(mask)))
        area = window.shell.workspace.canvas.area
        window.move(area.width / 2, area.height / 2).wait(4)
        assert window.shell.workspace.status_bar.hint.startswith("Feature 1 · Paint a mask")
        window.move(area.width / 2, area.height * 0.1).wait(4)
        assert window.shell.workspace.status_bar.hint.startswith("Paint a mask")
        window.context.mouse_move("//Warp/Rigid##keep")
        window.wait(4)
        assert window.shell.workspace.status_bar.hint.startswith("Each feature only moves and turns")

    drive(editor, script)


def test_what_is_seldom_needed_stands_under_advanced(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        window.item("//Warp/Advanced").wait(4)
        window.item("//Warp/Per quad##method").wait(3)
        window.context.item_input_value("//Warp/Weight/##number", 20.0)
        window.wait(3).screenshot(tmp_path / "advanced.png")

    drive(editor, script)
    assert editor.document.warp.method == "per-quad"
    assert editor.document.warp.weight == 20.0
