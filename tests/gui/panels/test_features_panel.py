"""Features one by one: the list, what can be done with its rows, new features under the brush, and the knife."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import ImVec2, hello_imgui, imgui

from app.editor.editor import Editor
from app.marking.feature_list import feature_list, rows_of
from app.model.jobs import Jobs
from app.model.session import Brush
from app.tools.all import TOOLS
from app.ui.widgets import theme
from core.document.document import Document
from core.document.feature import Feature
from core.document.project import load_project, save_project
from core.imaging.images import Image
from core.rasters.raster import Raster
from tests.app.driver import picture
from tests.gui.tools.test_select_tools import on_screen
from tests.gui.window_driver import WindowDriver, drive, inside

pytestmark = pytest.mark.gui

SIZE = 600, 400


def blocks(*sides: tuple[int, int]) -> Raster:
    """Return a mask of upright bars from left to right."""
    mask = np.zeros(SIZE[::-1], np.uint8)
    for left, right in sides:
        mask[120:280, left:right] = 255
    return Raster.from_array(mask)


@pytest.fixture
def editor() -> Iterator[Editor]:
    jobs = Jobs()
    start = Document.of(picture(*SIZE)).with_warp(cell_px=10.0)
    made = Editor(start, TOOLS, jobs=jobs)
    made.edit("Bars", start.changed(mask=blocks((60, 160), (240, 340), (420, 520))))
    made.show(brush=Brush(diameter_px=40.0, hardness=1.0))
    yield made
    jobs.close()


def show_list(window: WindowDriver) -> None:
    window.wait(4)
    hello_imgui.get_runner_params().docking_params.focus_dockable_window("Features")
    window.wait(4)


def ids(editor: Editor) -> list[int]:
    return [row.id for row in rows_of(editor)]


def test_rows_light_up_are_named_merged_given_up_and_removed(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        show_list(window)
        assert ids(editor) == [1, 2, 3]
        window.context.mouse_move("//Features/**/feature 2/##row")
        window.wait(3)
        assert editor.session.lit == 2
        pixels = window.screenshot(tmp_path / "lit.png")
        area, (x, y) = window.shell.workspace.canvas.area, on_screen(editor, (240, 200))[0]
        edge = pixels[round(area.y + y) - 2 : round(area.y + y) + 3, round(area.x + x) - 3 : round(area.x + x) + 4]
        accent = np.array([theme.ACCENT >> 16 & 255, theme.ACCENT >> 8 & 255, theme.ACCENT & 255])
        assert np.abs(edge.astype(int) - accent).max(axis=2).min() < 40

        window.context.item_double_click("//Features/**/feature 1/##row")
        window.wait(3).context.key_chars_replace_enter("Left bar")
        window.wait(3)
        assert editor.document.features == (Feature(1, "Left bar"),)
        assert ids(editor) == [1, 256, 257]

        window.item("//Features/**/feature 256/##row").wait(1)
        window.context.key_down(int(imgui.Key.mod_shift))
        window.item("//Features/**/feature 1/##row").wait(1)
        window.context.key_up(int(imgui.Key.mod_shift))
        window.item("//Features/Make one feature").wait(3)
        assert ids(editor) == [1, 256]
        assert [row.name for row in rows_of(editor)] == ["Left bar", "Feature 3"]

        window.item("//Features/**/feature 256/###keep").wait(3)
        assert ids(editor) == [1, 3]
        assert editor.document.given_up == {3}
        window.screenshot(tmp_path / "list.png")
        window.item("//Features/**/feature 3/###remove").wait(3)
        assert ids(editor) == [1]
        assert not editor.document.mask.array[:, 400:].any()

    drive(editor, script)
    assert editor.history.labels[2:] == ("Name feature", "Make one feature", "Give up feature", "Remove feature")
    save_project(editor.document, tmp_path / "kept.weft")
    again = load_project(tmp_path / "kept.weft")
    assert again.features == editor.document.features
    assert again.numbers is not None
    assert editor.document.numbers is not None
    assert np.array_equal(again.numbers.array, editor.document.numbers.array)
    editor.go_to(1)
    assert editor.document.numbers is None


def test_a_merged_feature_turns_as_one_and_one_that_is_given_up_bends(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        show_list(window)
        editor.show(features=frozenset({1, 3}))
        window.wait(2).item("//Features/Make one feature").wait(3)
        window.item("//Warp/**/Arch").wait(3).wait_until(lambda: editor.live.is_settled)

    drive(editor, script)
    result = editor.map.result
    assert result is not None
    assert [feature.id for feature in result.features] == [1, 256]
    assert max(feature.residual for feature in result.features) < 1e-6


def test_a_new_feature_does_not_join_what_it_touches(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        window.move(5, 5).key(imgui.Key.n).wait(2)
        assert editor.session.part == "new"
        window.drag(*on_screen(editor, (150, 200), (200, 200), (250, 200))).wait(3)
        assert ids(editor) == [256, 257, 258, 4]
        assert [row.name for row in rows_of(editor)] == [f"Feature {order}" for order in range(1, 5)]
        window.drag(*on_screen(editor, (250, 200), (300, 200))).wait(3)
        assert ids(editor) == [256, 257, 258, 4, 5]
        window.key(imgui.Key.n).wait(2)
        window.drag(*on_screen(editor, (420, 200), (330, 200))).wait(3)
        window.screenshot(tmp_path / "new.png")
        window.key(imgui.Key.mod_ctrl, imgui.Key.z).key(imgui.Key.mod_ctrl, imgui.Key.z).wait(3)
        assert ids(editor) == [256, 257, 258, 4]
        window.key(imgui.Key.x).drag(*on_screen(editor, (150, 200), (250, 200))).wait(3)

    drive(editor, script)
    assert editor.document.numbers is None
    assert not editor.document.mask.array[200, 170:230].any()


def test_the_knife_makes_two_of_one(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.move(5, 5).key(imgui.Key.u).wait(2)
        window.drag(*on_screen(editor, (110, 80), (110, 200), (112, 330))).wait(3)
        assert ids(editor) == [256, 257, 258, 4]
        window.drag(*on_screen(editor, (290, 80), (290, 200))).wait(3)
        assert ids(editor) == [256, 257, 258, 4]
        assert any("right across" in text for text in window.shell.workspace.toasts.texts)

    drive(editor, script)
    assert editor.history.labels[-1] == "Split feature"
    assert np.array_equal(editor.document.mask.array, blocks((60, 160), (240, 340), (420, 520)).array)


def test_the_masks_colour_and_strength_are_chosen(editor: Editor, tmp_path: Path) -> None:
    seen: list[np.ndarray] = []

    def script(window: WindowDriver) -> None:
        show_list(window)
        area, (x, y) = window.shell.workspace.canvas.area, on_screen(editor, (285, 205))[0]

        def shoot(name: str) -> None:
            pixels = window.move(5, 5).screenshot(tmp_path / f"{name}.png")
            seen.append(pixels[round(area.y + y), round(area.x + x)].astype(int))

        shoot("by_feature")
        editor.prefer(editor.preferences.changed(mask_color=0x00FF00, mask_opacity=1.0, feature_colors=False))
        shoot("green")

    drive(editor, script)
    assert seen[1].tolist() == [0, 255, 0]
    assert np.abs(seen[0] - seen[1]).max() > 60


def test_chosen_features_are_kept_each_in_its_way(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        show_list(window)
        window.item("//Warp/**/Arch").wait(3)
        window.item("//Features/**/feature 2/##row").wait(2).item("//Features/Rigid##keep one").wait(2)
        assert editor.document.features == (Feature(2, keep="rigid"),)
        window.item("//Features/Upright").wait(2)
        window.item("//Features/**/feature 257/##row").wait(2)
        window.context.item_input_value("//Features/Size to/##number", 80.0)
        window.item("//Features/**/feature 256/##row").wait(2)
        window.context.item_input_value("//Features/Protection/##number", 50.0)
        window.wait(2).wait_until(lambda: editor.live.is_settled)
        window.screenshot(tmp_path / "keeping.png")

    drive(editor, script)
    features = Feature(1, weight=0.5), Feature(2, keep="rigid", upright=True), Feature(3, most=0.8)
    assert editor.document.features == features
    assert editor.history.labels[-4:] == (
        "Keep feature as",
        "Upright feature",
        "Size of feature",
        "Protection of feature",
    )
    result = editor.map.result
    assert result is not None
    found = {feature.id: feature for feature in result.features}
    assert (found[2].scale, found[2].angle_deg) == pytest.approx((1, 0), abs=1e-6)
    assert found[3].scale <= 0.8 + 1e-6
    assert 1e-3 < found[1].residual < 0.1
    save_project(editor.document, tmp_path / "kept.weft")
    assert load_project(tmp_path / "kept.weft").features == editor.document.features


@pytest.mark.parametrize("size", [(1280, 900), (1600, 1000)])
def test_the_settings_of_a_chosen_feature_are_in_sight_at_once(
    editor: Editor, size: tuple[int, int], tmp_path: Path
) -> None:
    sides = [(30 + 60 * n, 60 + 60 * n) for n in range(9)]
    editor.edit("Nine", editor.document.changed(mask=blocks(*sides)))

    def script(window: WindowDriver) -> None:
        show_list(window)
        window.item("//Features/**/feature 2/##row").wait(3)
        window.screenshot(tmp_path / "chosen.png")
        panel = inside("Features")
        assert panel.scroll.y == 0
        for name in ("Lines##keep one", "Upright", "Protection/##number", "Size from/##number", "Size to/##number"):
            rect = window.context.item_info(f"//Features/{name}").rect_full
            assert panel.inner_rect.min.y <= rect.min.y
            assert rect.max.y <= panel.inner_rect.max.y, name
        window.context.mouse_move("//Features/**/feature 1/##row")
        window.context.mouse_wheel(ImVec2(0, -30))
        window.wait(3).item("//Features/**/feature 9/##row").wait(3)
        assert editor.session.features == {9}

    drive(editor, script, size=size)


def test_of_a_feature_only_its_straight_lines_are_kept(editor: Editor, tmp_path: Path) -> None:
    pixels = np.full((*SIZE[::-1], 3), 190, np.uint8)
    pixels[180:220, 20:580] = 40
    document = editor.document.changed(image=Image(pixels), mask=blocks((40, 560)))
    editor.edit("Wall", document)
    found: list[float] = []

    def measure(window: WindowDriver) -> None:
        """Find how far the upper side of the bar is from straight inside the feature, in pixels."""
        window.wait(2).wait_until(lambda: editor.live.is_settled)
        result = editor.map.result
        assert result is not None
        assert not result.features
        at = np.stack([np.linspace(60, 540, 60), np.full(60, 179.5)], axis=1)
        nodes, weights = result.grid.weights_at(at)
        x, y = (result.warped.reshape(-1, 2)[nodes] * weights[..., None]).sum(axis=1).T
        found.append(float(np.abs(y - np.polyval(np.polyfit(x, y, 1), x)).max()))

    def script(window: WindowDriver) -> None:
        show_list(window)
        window.item("//Warp/**/Arch").wait(3)
        window.item("//Features/**/feature 1/##row").wait(2).item("//Features/**/feature 1/###keep")
        measure(window)
        window.item("//Features/**/feature 1/###keep").wait(2).item("//Features/Lines##keep one")
        measure(window)
        window.screenshot(tmp_path / "lines.png")
        assert owners_in(editor) == {0, 1}
        window.context.item_input_value("//Features/Protection/##number", 50.0)
        measure(window)
        window.item("//Features/Upright").wait(2).context.item_input_value("//Features/Size to/##number", 120.0)
        measure(window)

    drive(editor, script)
    assert found[1] < 0.3 * found[0]
    assert 1.5 * found[1] < found[2] < 0.8 * found[0]
    assert editor.document.features == (Feature(1, keep="lines", weight=0.5, upright=True, most=1.2),)
    save_project(editor.document, tmp_path / "kept.weft")
    assert load_project(tmp_path / "kept.weft").features == editor.document.features


def owners_in(editor: Editor) -> set[int]:
    """Return the colours that features have in the picture."""
    return set(np.unique(feature_list(editor).owners(editor.document, editor.map.grid, 12)).tolist())
