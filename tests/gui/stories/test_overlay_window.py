"""Overlay mode in the real window, by mouse and keys."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from app.model.jobs import Jobs
from app.model.spaces import screen_from_canvas
from app.tools.all import TOOLS
from app.tools.cloth.lattice import on_screen, vertices
from core.arrays import Bytes
from core.document.document import Document, pixels_from_places
from core.imaging import color
from core.imaging.images import Image, save
from tests.app.driver import picture
from tests.core.overlay.overlay_scenes import make_scene, motif
from tests.core.overlay.prints import usual_vectors
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui
WIDTH, HEIGHT = 150, 130
POINTER_PX = 20
SCENE = make_scene(motif(), size=(HEIGHT, WIDTH))
PHOTO = Image(color.quantise(SCENE.photo.astype(np.float32), np.uint8))


@pytest.fixture
def editor() -> Iterator[Editor]:
    jobs = Jobs()
    yield Editor(Document.of(PHOTO).changed(mode="overlay"), TOOLS, jobs=jobs)
    jobs.close()


def place(editor: Editor, x: float, y: float) -> tuple[float, float]:
    """Return where a pixel of the photo is on the canvas."""
    at = screen_from_canvas(editor.session.view, np.array([x, y]))
    return float(at[0]), float(at[1])


def cloth_in(window: WindowDriver, path: Path) -> Bytes:
    """Return the part of a screenshot that shows the middle of the photo."""
    shot, area = window.screenshot(path), window.shell.workspace.canvas.area
    (left, top), (right, bottom) = place(window.editor, 40, 40), place(window.editor, 110, 90)
    return shot[int(area.y + top) : int(area.y + bottom), int(area.x + left) : int(area.x + right)].astype(np.uint8)


def test_from_photo_to_new_cloth(editor: Editor, tmp_path: Path) -> None:
    save(picture(80, 60), tmp_path / "new.png")
    seen = {}

    def script(window: WindowDriver) -> None:
        window.wait(8)
        window.item("//Overlay/Find pattern").wait_until(lambda: editor.overlay.is_final).wait(6)
        window.move(*place(editor, 5, 5)).wait(4)
        seen["old"] = cloth_in(window, tmp_path / "old.png")
        window.shell.workspace.drop([tmp_path / "new.png"])
        window.wait_until(lambda: editor.document.cloth.texture is not None).wait(40)
        seen["new"] = cloth_in(window, tmp_path / "new_shot.png")
        window.press(*place(editor, 60, 60))
        for step in range(1, 6):
            window.move(*place(editor, 60 + 2 * step, 60)).wait(1)
        window.release().move(*place(editor, 5, 5)).wait(40)
        seen["moved"] = cloth_in(window, tmp_path / "moved.png")
        window.key(imgui.Key._2).wait(20)
        seen["photo"] = cloth_in(window, tmp_path / "photo.png")
        window.key(imgui.Key.mod_ctrl, imgui.Key.z).wait(4)

    drive(editor, script)
    assert editor.history.labels == ("Open", "Find pattern", "Texture new.png", "Move texture")
    assert editor.document.cloth.laying.offset == (0.0, 0.0)
    difference = {name: np.abs(shot.astype(int) - seen["old"]).mean() for name, shot in seen.items()}
    assert difference["new"] > 20
    assert np.abs(seen["moved"].astype(int) - seen["new"]).mean() > 10
    assert difference["photo"] < 12


def test_a_region_and_a_texel_are_drawn_on_the_photo(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.wait(8).move(*place(editor, 5, 5)).key(imgui.Key.r).wait(3)
        window.drag(place(editor, 20, 30), place(editor, 60, 60), place(editor, 130, 110)).wait(3)
        window.context.key_down(int(imgui.Key.mod_alt))
        window.drag(place(editor, 100, 80), place(editor, 120, 95), place(editor, 140, 120)).wait(3)
        window.context.key_up(int(imgui.Key.mod_alt))
        window.move(*place(editor, 5, 5)).key(imgui.Key.i).wait(3)
        window.drag(place(editor, 52, 40), place(editor, 60, 50), place(editor, 76, 62))
        window.wait_until(lambda: editor.overlay.is_final)

    drive(editor, script)
    assert editor.history.labels == ("Open", "Region", "Cut from region", "Mark texel")
    cloth, layers = editor.document.cloth, editor.overlay.layers
    assert cloth.region is not None
    inside = np.zeros((HEIGHT, WIDTH), bool)
    inside[30:111, 20:131] = True
    inside[80:, 100:] = False
    assert ((cloth.region.array > 127) ^ inside).sum() < 250, "to a pixel at its border"
    assert cloth.search is not None
    assert cloth.search.region is cloth.region
    assert np.allclose(pixels_from_places((WIDTH, HEIGHT), np.array(cloth.search.texel)), [[52, 40], [76, 62]], atol=1)
    assert layers is not None
    assert layers.covered[inside].mean() > 0.8
    assert not layers.covered[cloth.region.array == 0].any()
    assert np.linalg.det(layers.basis) == pytest.approx(np.linalg.det(usual_vectors(SCENE, inside)), rel=0.02)


def test_cover_is_painted_on_the_result(editor: Editor, tmp_path: Path) -> None:
    save(picture(80, 60), tmp_path / "new.png")
    seen = {}

    def script(window: WindowDriver) -> None:
        window.wait(8).move(*place(editor, 5, 5)).key(imgui.Key.r).wait(3)
        window.drag(place(editor, 5, 5), place(editor, 20, 60), place(editor, 70, 125)).wait(3)
        window.item("//Overlay/Find pattern").wait_until(lambda: editor.overlay.is_final).wait(6)
        window.shell.workspace.drop([tmp_path / "new.png"])
        window.wait_until(lambda: editor.document.cloth.texture is not None).wait(20)
        window.shell.workspace.table.run("overlay.paint_covered", editor)
        window.move(*place(editor, 5, 5)).wait(40)
        seen["before"] = cloth_in(window, tmp_path / "before.png")
        window.press(*place(editor, 85, 60))
        for step in range(1, 8):
            window.move(*place(editor, 85 + 2 * step, 60)).wait(1)
        seen["painted"] = cloth_in(window, tmp_path / "painted.png")
        window.release().wait_until(lambda: editor.overlay.is_final)
        window.move(*place(editor, 5, 5)).wait(40)
        seen["covered"] = cloth_in(window, tmp_path / "covered.png")

    drive(editor, script)
    assert editor.history.labels[-1] == "Paint cover"
    layers = editor.overlay.layers
    assert layers is not None
    assert layers.uncovered is not None
    assert layers.covered[60, 90]
    assert not layers.uncovered.covered[60, 90]
    changed = {name: np.abs(shot.astype(int) - seen["before"]).mean(-1) for name, shot in seen.items()}
    middle, scale = changed["covered"].shape[0] * 20 // 50, changed["covered"].shape[1] / 70
    there, beside = round(50 * scale), round(15 * scale)
    spot = (slice(middle - 5, middle + 5), slice(there - 5, there + 5))
    assert changed["painted"][spot].mean() > 10, "what is painted is tinted at once"
    assert changed["covered"][spot].mean() > 10
    assert np.abs(seen["covered"].astype(int) - seen["painted"])[spot].mean() > 10, (
        "there is the texture then, untinted"
    )
    assert changed["covered"][:, : 2 * beside].mean() < 1, "the texture stays where it was"


def test_vertex_is_dragged_on_the_canvas(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.wait(8).item("//Overlay/Find pattern").wait_until(lambda: editor.overlay.is_final).wait(4)
        window.move(*place(editor, 5, 5)).key(imgui.Key.l).wait(3)
        assert editor.session.tool == "lattice"
        lattice = vertices(editor)
        assert lattice is not None
        points = on_screen(editor, lattice)
        x, y = points[np.argmin(np.hypot(*(points - place(editor, 75, 65)).T))].tolist()
        window.drag((x, y), (x + 6, y + 2), (x + 8, y + 4)).wait(3)
        assert editor.overlay.is_running or editor.overlay.is_final
        window.wait_until(lambda: editor.overlay.is_final)

    drive(editor, script)
    assert editor.history.labels[-1] == "Move lattice vertex"
    search = editor.document.cloth.search
    assert search is not None
    assert search.mending is not None
    assert len(search.mending.held) == 1, "the vertex that was moved stays where it was put"


def test_the_rows_of_the_panel_stay_where_they_are(editor: Editor) -> None:
    rows: dict[str, list[float]] = {}

    def note(window: WindowDriver, state: str) -> None:
        window.wait(3)
        names = ("Seed/##track", "Size/##track", "Down/##track", "Shading/##track")
        rows[state] = [window.context.item_info(f"//Overlay/{name}").rect_full.min.y for name in names]

    def script(window: WindowDriver) -> None:
        window.wait(8)
        note(window, "unsought")
        editor.overlay.fault = "no repeating pattern found"
        note(window, "at fault")
        editor.overlay.fault = None
        window.item("//Overlay/Find pattern").wait(2)
        assert editor.overlay.is_running
        note(window, "running")
        window.item("//Overlay/Cancel")
        note(window, "stopped")
        editor.edit("Texture", editor.document.with_cloth(texture=picture(80, 60), texture_name="new.png"))
        note(window, "with a texture")
        window.item("//Overlay/Go on").wait_until(lambda: editor.overlay.is_final)
        note(window, "found")
        cloth = editor.document.cloth.with_laying(size=3.0, rotate_deg=20.0, stretch=1.5)
        editor.edit("Lay", editor.document.changed(cloth=cloth))
        note(window, "set")

    drive(editor, script)
    assert len(rows) == 7
    assert all(places == rows["unsought"] for places in rows.values()), rows


def test_the_view_that_is_seen_is_the_one_that_is_lit(editor: Editor) -> None:
    lit: dict[str, list[str]] = {}

    def script(window: WindowDriver) -> None:
        by_name = window.shell.workspace.table.by_name
        views = [action for name, action in by_name.items() if name.startswith("shown.")]
        window.wait(8).item("//Overlay/Find pattern").wait_until(lambda: editor.overlay.is_final)
        for tool in ("drape", "lattice"):
            editor.choose_tool(tool)
            lit[tool] = [view.label for view in views if view.checked is not None and view.checked(editor)]
        by_name["shown.result"].run(editor)

    drive(editor, script)
    assert lit == {"drape": ["Result"], "lattice": ["Photo"]}
    assert editor.session.tool == "drape"


def test_what_explains_a_button_of_the_panel_stands_beside_it(editor: Editor, tmp_path: Path) -> None:
    shots, edges = {}, []

    def script(window: WindowDriver) -> None:
        window.wait(8).move(*place(editor, 5, 5))
        shots["away"] = window.screenshot(tmp_path / "away.png").astype(int)
        window.context.mouse_move("//Overlay/Find pattern")
        shots["on"] = window.wait(90).screenshot(tmp_path / "on.png").astype(int)
        item = window.context.item_info("//Overlay/Find pattern")
        assert item.window is not None
        edges.extend([item.window.pos.x, item.rect_full.max.y + POINTER_PX])

    drive(editor, script)
    left, below = (int(edge) for edge in edges)
    change = np.abs(shots["on"] - shots["away"]).max(-1)
    assert change[below : below + 200, left:].max() < 10
    assert change[: below + 200, left - 300 : left].max() > 50
