"""Retexture mode in the real window, by mouse and keys."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from app.model.jobs import Jobs
from app.model.spaces import screen_from_canvas
from app.tools.all import TOOLS
from core.arrays import Points
from core.curves.bezier import Curve
from core.document.document import CurvePair, Document, pixels_from_places, places_from_pixels
from core.imaging.images import Image
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


def on_screen(editor: Editor, x: float, y: float) -> tuple[float, float]:
    """Return where a pixel of the result is on the canvas."""
    place = screen_from_canvas(editor.session.view, np.array([x, y]))
    return float(place[0]), float(place[1])


def line(*points: tuple[float, float]) -> Points:
    return places_from_pixels((600, 400), np.array(points, float))


def test_a_target_is_dragged_and_the_texture_regrown(editor: Editor, tmp_path: Path) -> None:
    straight = line((150, 200), (250, 200), (350, 200), (450, 200))
    editor.choose_mode("retexture")
    editor.edit("Draw curve", editor.document.changed(feature_curves=(CurvePair(straight, straight),)))
    seen = {}

    def script(window: WindowDriver) -> None:
        window.wait(8)
        assert not window.shell.params.docking_params.dockable_window_of_name("Warp").is_visible
        assert editor.session.tool == "feature-curves"
        window.press(*on_screen(editor, 300, 200)).wait()
        for step in range(8):
            window.move(*on_screen(editor, 300, 200 + 6 * step)).wait(1)
        seen["live"] = window.screenshot(tmp_path / "live.png")
        window.release().wait_until(lambda: editor.regrowth.is_final)
        for key, name in ((imgui.Key._1, "original"), (imgui.Key._2, "deformed"), (imgui.Key._3, "retextured")):
            window.move(*on_screen(editor, 500, 330)).key(key).wait(3)
            assert editor.session.look == name
            seen[name] = window.screenshot(tmp_path / f"{name}.png")

    drive(editor, script)
    assert editor.history.labels[-1] == "Bend curve"
    assert editor.regrowth.stage is not None
    names = ("live", "original", "deformed", "retextured")
    for first, second in [(a, b) for a in names for b in names if a < b]:
        assert np.abs(seen[first].astype(int) - seen[second]).mean() > 0.05, (first, second)


def test_a_curve_is_traced_along_an_edge() -> None:
    y, x = np.mgrid[:300, :400]
    away = np.hypot(x - 200, y - 150)
    grey = np.where(away < 90, 50, 190) + np.random.default_rng(0).integers(0, 12, away.shape)
    disc = Image(np.repeat(grey[..., None], 3, axis=2).astype(np.uint8))
    editor = Editor(Document.of(disc).changed(mode="retexture"), TOOLS, jobs=Jobs())

    def script(window: WindowDriver) -> None:
        window.wait(8).move(*on_screen(editor, 20, 20)).key(imgui.Key.t).wait(3)
        window.click(*on_screen(editor, 110, 150)).wait(40)
        window.move(*on_screen(editor, 140, 80)).wait(3)
        assert editor.session.draft is not None
        window.click(*on_screen(editor, 200, 60)).wait(40).key(imgui.Key.enter).wait(3)

    drive(editor, script)
    editor.jobs.close()
    assert editor.history.labels == ("Open", "Trace curve")
    traced = Curve(pixels_from_places((400, 300), editor.document.feature_curves[0].source))
    points = traced.at(traced.parameters(step=2.0))
    assert np.abs(np.hypot(*(points - (200, 150)).T) - 90).max() < 3
    assert len(points) > 60, "a quarter of the disc's edge"


def test_the_modes_are_switched_by_key_and_back(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.key(imgui.Key.mod_alt, imgui.Key._2).wait(4)
        modes = [editor.session.mode]
        window.item("//Retexture/Deformed##look").wait()
        assert editor.session.look == "deformed"
        window.key(imgui.Key.mod_alt, imgui.Key._1).wait(4)
        assert [*modes, editor.session.mode] == ["retexture", "warp"]
        window.item("//Warp/**/Arch").wait()

    drive(editor, script)
    assert editor.history.labels[-1] == "Preset Arch"


def test_before_and_after_stand_side_by_side(editor: Editor, tmp_path: Path) -> None:
    straight = line((100, 200), (250, 200), (350, 200), (500, 200))
    moved = straight + [0, 0.2]
    editor.choose_mode("retexture")
    editor.edit("Draw curve", editor.document.changed(feature_curves=(CurvePair(straight, moved),)))
    seen = {}

    def script(window: WindowDriver) -> None:
        editor.choose_tool("hand")
        editor.show(overlays=replace(editor.session.overlays, handles=False))
        window.wait_until(lambda: editor.regrowth.is_final)
        for compare in ("before", "split", "result"):
            editor.show(compare=compare)
            window.wait(4).wait_until(lambda: not window.shell._renderer.is_refining)
            seen[compare] = window.screenshot(tmp_path / f"{compare}.png")

    drive(editor, script)
    middle = slice(300, 600)
    left, right = (slice(a, b) for a, b in ((150, 400), (700, 950)))
    assert np.array_equal(seen["split"][middle, left], seen["before"][middle, left])
    assert np.array_equal(seen["split"][middle, right], seen["result"][middle, right])
    assert not np.array_equal(seen["before"][middle, left], seen["result"][middle, left])
    assert not np.array_equal(seen["before"][middle, right], seen["result"][middle, right])


def test_the_rows_of_the_panel_stay_where_they_are(editor: Editor) -> None:
    straight = line((150, 200), (250, 200), (350, 200), (450, 200))
    rows: dict[str, list[float]] = {}

    def note(window: WindowDriver, state: str) -> None:
        window.wait(3)
        names = ("Length/##track", "Seed/##track", "Motion reach/##track", "Clear matte")
        rows[state] = [window.context.item_info(f"//Retexture/{name}").rect_full.min.y for name in names]

    def curve(**changes: object) -> None:
        editor.edit("Curve", editor.document.changed(feature_curves=(CurvePair(straight, straight, **changes),)))  # type: ignore[arg-type]

    def script(window: WindowDriver) -> None:
        editor.choose_mode("retexture")
        editor.show(auto_retexture=False)
        window.wait(8)
        note(window, "empty")
        curve()
        editor.show(selected_curve=0)
        note(window, "a curve in hand")
        curve(passive=True)
        note(window, "passive")
        away = CurvePair(straight, straight + [0, 5])
        editor.edit("Lose", editor.document.changed(feature_curves=(away,)))
        window.wait(3).item("//Retexture/Retexture").wait_until(lambda: editor.regrowth.fault is not None)
        note(window, "at fault")
        editor.edit("Set", editor.document.with_retexture(seed=3, along_px=51, reach=0.2, move_within=0.3))
        note(window, "set")

    drive(editor, script, size=(1440, 1200))
    assert len(rows) == 5
    assert all(places == rows["empty"] for places in rows.values()), rows
