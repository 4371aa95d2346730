"""Each tool that selects, by mouse and keys in the window."""

from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from app.model.jobs import Jobs
from app.model.session import Selecting
from app.model.spaces import screen_from_canvas
from app.tools.all import SELECTING, TOOLS
from app.tools.split import SPLIT
from core.arrays import Bools, Bytes
from core.document.document import Document
from core.imaging.images import Image
from core.rasters.raster import Raster
from tests.gui.window.test_small_windows import bar
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui

SIZE = 600, 400
CENTRE, RADIUS = (300, 200), 70
Places = list[tuple[float, float]]


def disc() -> Bools:
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    return np.asarray(np.hypot(x - CENTRE[0], y - CENTRE[1]) < RADIUS)


def scene() -> Image:
    """Return an orange disc on a noisy blue ground, and a small orange square far from it."""
    noise = np.random.default_rng(0).integers(0, 12, (SIZE[1], SIZE[0], 3))
    pixels = np.where(disc()[..., None], (220, 120, 30), (40, 80, 160)) + noise
    pixels[20:40, 20:40] = (226, 126, 36)
    return Image(pixels.astype(np.uint8))


@pytest.fixture
def editor() -> Iterator[Editor]:
    jobs = Jobs()
    yield Editor(Document.of(scene()).with_warp(cell_px=20.0), TOOLS, jobs=jobs)
    jobs.close()


def on_screen(editor: Editor, *places: tuple[float, float]) -> Places:
    """Return where pixels of the picture are on the canvas."""
    found = screen_from_canvas(editor.session.view, np.array(places))
    return [(float(x), float(y)) for x, y in found]


def marked(editor: Editor) -> Bytes:
    return np.asarray(editor.document.mask.array)


def overlap(mask: Bytes, area: Bools) -> float:
    """Return the intersection of two areas over their union."""
    inside = mask > 127
    return float((inside & area).sum() / max((inside | area).sum(), 1))


def box(left: int, top: int, right: int, bottom: int) -> Bools:
    area = np.zeros(SIZE[::-1], bool)
    area[top:bottom, left:right] = True
    return area


def run(editor: Editor, tool: str, deed: Callable[[WindowDriver], object], shot: Path | None = None) -> None:
    """Take a tool by its key, do something with it and wait for what comes of it."""

    def script(window: WindowDriver) -> None:
        window.move(5, 5).key(getattr(imgui.Key, TOOLS[tool].key)).wait(2)
        assert editor.session.tool == tool
        deed(window)
        window.wait_until(lambda: editor.jobs.is_idle and not editor.is_busy).wait(2)
        if shot is not None:
            window.screenshot(shot)

    drive(editor, script)


def test_rectangle(editor: Editor) -> None:
    run(editor, "rectangle", lambda w: w.drag(*on_screen(editor, (100, 50), (160, 90), (200, 150))))
    assert overlap(marked(editor), box(100, 50, 201, 151)) > 0.97
    assert editor.history.labels[-1] == "Add rectangle"


def test_ellipse_and_a_circle_with_ctrl(editor: Editor) -> None:
    def deed(window: WindowDriver) -> None:
        window.drag(*on_screen(editor, (230, 130), (300, 200), (370, 270)))

    run(editor, "ellipse", deed)
    assert overlap(marked(editor), disc()) > 0.97


def test_lasso(editor: Editor, tmp_path: Path) -> None:
    corners = [(100.0, 100.0), (150.0, 95.0), (200.0, 100.0), (200.0, 180.0), (150.0, 185.0), (100.0, 180.0)]
    run(editor, "lasso", lambda w: w.drag(*on_screen(editor, *corners)), tmp_path / "lasso.png")
    assert overlap(marked(editor), box(100, 98, 201, 183)) > 0.94


@pytest.mark.parametrize("ends", ["enter", "first", "double"])
def test_polygon_closes_by_enter_by_its_first_corner_and_by_a_double_click(editor: Editor, ends: str) -> None:
    def deed(window: WindowDriver) -> None:
        places = on_screen(editor, (100, 100), (300, 100), (500, 360), (300, 300), (100, 300))
        for place in places[:3]:
            window.click(*place).wait(40)  # far apart: no double clicks
        window.key(imgui.Key.backspace)
        for place in places[3:]:
            window.click(*place).wait(40)
        if ends == "enter":
            window.key(imgui.Key.enter)
        elif ends == "first":
            window.click(*places[0])
        else:
            window.move(*places[-1]).context.mouse_double_click(0)

    run(editor, "polygon", deed)
    assert overlap(marked(editor), box(100, 100, 301, 301)) > 0.97
    assert editor.history.labels == ("Open", "Add polygon")


def test_an_outline_that_is_given_up_leaves_no_trace(editor: Editor) -> None:
    def deed(window: WindowDriver) -> None:
        window.click(*on_screen(editor, (100, 100))[0]).wait(40).click(*on_screen(editor, (300, 100))[0]).wait(2)
        assert editor.session.selection is not None
        window.key(imgui.Key.escape)

    run(editor, "polygon", deed)
    assert editor.session.selection is None
    assert editor.history.index == 0


def test_the_lasso_along_edges_clings_to_the_disc(editor: Editor, tmp_path: Path) -> None:
    def deed(window: WindowDriver) -> None:
        angles = np.linspace(0, 2 * np.pi, 6, endpoint=False)
        rough = [(CENTRE[0] + (RADIUS + 3) * np.cos(a), CENTRE[1] + (RADIUS - 3) * np.sin(a)) for a in angles]
        for place in on_screen(editor, *rough):
            window.click(*place).wait(40)
        window.screenshot(tmp_path / "cling.png")
        window.key(imgui.Key.enter)

    run(editor, "cling", deed)
    assert overlap(marked(editor), disc()) > 0.94


def test_the_wand_takes_what_hangs_together_or_everything_alike(editor: Editor) -> None:
    def deed(window: WindowDriver) -> None:
        window.click(*on_screen(editor, CENTRE)[0])

    run(editor, "wand", deed)
    assert overlap(marked(editor), disc()) > 0.99
    assert marked(editor)[30, 30] == 0
    editor.undo()
    editor.show(selecting=Selecting(contiguous=False))
    run(editor, "wand", deed)
    assert marked(editor)[30, 30] == 255


def test_a_range_of_colours_is_selected_wherever_it_is(editor: Editor) -> None:
    run(editor, "colour-range", lambda w: w.drag(*on_screen(editor, (290, 190), (310, 200))))
    assert overlap(marked(editor), disc() | box(20, 20, 40, 40)) > 0.99


@pytest.mark.parametrize("by_stroke", [False, True])
def test_an_object_in_a_box_or_under_rough_paint(editor: Editor, by_stroke: bool) -> None:
    def deed(window: WindowDriver) -> None:
        if by_stroke:
            window.shell.workspace.table.run("select.by_stroke", editor)
            window.drag(*on_screen(editor, (260, 200), (300, 160), (340, 200), (300, 240), (260, 200)))
        else:
            window.drag(*on_screen(editor, (200, 110), (300, 200), (400, 290)))

    run(editor, "object", deed)
    assert overlap(marked(editor), disc()) > 0.97


def test_selections_are_cut_out_and_crossed_by_keys(editor: Editor) -> None:
    def deed(window: WindowDriver) -> None:
        window.drag(*on_screen(editor, (100, 100), (200, 150), (300, 300)))
        for key, places in (
            (imgui.Key.mod_alt, [(150, 150), (180, 180), (200, 200)]),
            (None, [(400, 100), (420, 120), (450, 150)]),
        ):
            if key is not None:
                window.context.key_down(int(key))
            window.drag(*on_screen(editor, *places))
            if key is not None:
                window.context.key_up(int(key))
        window.shell.workspace.table.run("select.intersect", editor)
        window.drag(*on_screen(editor, (50, 50), (300, 200), (420, 320)))

    run(editor, "rectangle", deed)
    kept = box(100, 100, 301, 301) & ~box(150, 150, 201, 201) | box(400, 100, 421, 151)
    assert overlap(marked(editor), kept) > 0.97
    assert editor.history.labels[1:] == ("Add rectangle", "Cut out rectangle", "Add rectangle", "Intersect rectangle")


def test_every_selection_tool_stands_in_the_bar_behind_one_button(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("mask.fill", editor)  # the knife needs a feature
        window.key(imgui.Key.r).wait(3)
        window.screenshot(tmp_path / "bar.png")
        for tool in SELECTING:
            window.item(f"//{bar('##Top')}/###in bar {tool.label}").wait(2)
            assert editor.session.tool == tool.name
        window.key(imgui.Key.b).wait(2)
        assert editor.session.select_tool == SELECTING[-1].name

    drive(editor, script)


def test_a_mask_is_refined_from_its_menu(editor: Editor) -> None:
    editor.show(selecting=Selecting(refine_px=5.0))
    ring = np.where(disc(), 255, 0).astype(np.uint8)
    cv2.circle(ring, CENTRE, 20, (0,), -1)

    def script(window: WindowDriver) -> None:
        editor.edit("Ring", editor.document.changed(mask=Raster.from_array(ring)))
        for name in ("fill_holes", "grow", "shrink", "smooth", "feather"):
            window.context.set_ref("##MainMenuBar")
            window.context.menu_click(f"Mask/Refine/###mask.{name}")
            window.wait(2)

    drive(editor, script)
    assert editor.history.labels[2:] == ("Fill holes mask", "Grow mask", "Shrink mask", "Smooth mask", "Feather mask")
    assert overlap(marked(editor), disc()) > 0.98
    assert set(np.unique(marked(editor))) - {0, 255}


def test_the_knife_waits_for_a_feature_and_does_not_stand_for_the_others(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.key(imgui.Key.r).wait(3)
        window.item(f"//{bar('##Top')}/###in bar {SPLIT.label}").wait(2)
        assert editor.session.tool == "rectangle"
        window.key(imgui.Key.u).wait(2)
        assert editor.session.tool == "rectangle"
        window.shell.workspace.table.run("mask.fill", editor)
        window.wait(2).item(f"//{bar('##Top')}/###in bar {SPLIT.label}").wait(2)
        assert editor.session.tool == "split"
        window.shell.workspace.table.run("mask.clear", editor)
        window.key(imgui.Key.b).wait(3)
        window.item(f"//{bar('##Left')}/###{SELECTING[0].label}").wait(2)
        assert editor.session.tool == SELECTING[0].name

    drive(editor, script)
