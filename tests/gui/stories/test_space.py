"""A label on a mug, and other surfaces in space, by mouse (FAT fig. 5)."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui

from app.editor.editor import Editor
from app.model.jobs import Jobs
from app.model.orbit import Orbit
from app.render.picture_file import exporting
from app.tools.all import TOOLS
from app.ui.widgets.controls import segments
from core.arrays import Bytes, Floats
from core.document.document import Document
from core.imaging.images import Image, load, save
from core.surfaces.mesh_file import read_mesh
from core.surfaces.shapes import make_shape
from core.surfaces.surface import Surface
from tests.core.surfaces.test_surface import write_obj
from tests.gui.stories.test_stories import export, open_picture, settle
from tests.gui.window_driver import WindowDriver, drive

pytestmark = [pytest.mark.gui, pytest.mark.slow]
SIZE = 480, 240
EMBLEMS = ((150, 70), (330, 165))
RADIUS = 30


@pytest.fixture
def editor() -> Iterator[Editor]:
    """Make an editor on a picture of nothing much."""
    jobs = Jobs()
    yield Editor(Document.of(Image(np.full((40, 60, 3), 128, np.uint8))), TOOLS, jobs=jobs, exporter=exporting)
    jobs.close()


def label() -> tuple[Bytes, Bytes]:
    """Return a label with two round emblems, and their mask."""
    picture, mask = np.full((*SIZE[::-1], 3), (60, 120, 90), np.uint8), np.zeros((*SIZE[::-1], 1), np.uint8)
    for emblem in EMBLEMS:
        cv2.circle(picture, emblem, RADIUS, (250, 240, 220), -1, cv2.LINE_AA)
        cv2.circle(mask, emblem, RADIUS + 3, 255, -1)
    return picture, mask


def mug() -> Surface:
    """Return a mug: its wall shows most of the texture, a ring for a handle the rest at the right."""
    wall, handle = make_shape("cylinder", 1.2), make_shape("torus", 0.25)
    vertices: Floats = np.concatenate([wall.vertices, 0.5 * handle.vertices[:, [0, 2, 1]] + [1.3, 0, 0]])
    texture = np.concatenate([wall.texture * [0.9, 1], handle.texture * [0.09, 1] + [0.91, 0]])
    return Surface("mug", vertices, texture, np.concatenate([wall.triangles, handle.triangles + len(wall.vertices)]))


def ovalness(texture: Bytes) -> list[float]:
    """Return by how much each emblem of a label is wider than high on the wall of the mug."""
    light = (texture[..., 0] > 150).astype(np.uint8)
    count, _, stats, _ = cv2.connectedComponentsWithStats(light)
    # The wall is 2 pi wide over nine tenths of the texture, and 2.4 high.
    per_px = 2 * np.pi / (0.9 * SIZE[0]), 2.4 / SIZE[1]
    large = [row for row in stats[1:count] if row[cv2.CC_STAT_AREA] > 300]
    widths = [row[cv2.CC_STAT_WIDTH] * per_px[0] / (row[cv2.CC_STAT_HEIGHT] * per_px[1]) for row in large]
    return [float(width) for width in widths]


def test_a_label_on_a_mug_is_round_on_it_and_its_texture_and_view_are_exported(editor: Editor, tmp_path: Path) -> None:
    picture, mask = label()
    save(Image(picture), tmp_path / "label.png")
    save(Image(mask), tmp_path / "mask.png")
    write_obj(tmp_path / "mug.obj", mug())

    def script(window: WindowDriver) -> None:
        open_picture(window, tmp_path / "label.png")
        window.shell.workspace.table.run("mask.load", editor)
        window.wait(3)
        window.context.item_input_value("//Load mask/##name", str(tmp_path / "mask.png"))
        window.wait_until(lambda: not editor.document.mask.is_empty)
        settle(window)
        window.item("//Warp/In space##page").wait(2)
        window.item("//Warp/Mesh…").wait(3)
        window.context.item_input_value("//Open a mesh to lay the picture on/##name", str(tmp_path / "mug.obj"))
        window.wait_until(lambda: editor.document.surface is not None)
        settle(window)
        window.screenshot(tmp_path / "mug.png")
        before = window.screenshot(tmp_path / "before.png").astype(int)
        turned = editor.session.orbit
        window.context.mouse_move("//In space/Features kept")
        window.context.mouse_down(0)
        at = window.context.mouse_move_to_pos
        place = imgui.get_mouse_pos()
        at(ImVec2(place.x + 60, place.y + 20))
        window.context.mouse_up(0)
        assert editor.session.orbit.turn_deg < turned.turn_deg
        assert editor.session.orbit.tilt_deg > turned.tilt_deg
        assert np.abs(window.screenshot(tmp_path / "after.png") - before).max() > 40
        texture = export(window, tmp_path / "texture.png")
        assert texture.shape == (*SIZE[::-1], 3)
        plain, kept = ovalness(picture), ovalness(texture)
        assert all(abs(ratio - 1) > 0.3 for ratio in plain)
        np.testing.assert_allclose(kept, 1, atol=0.06)  # a pixel of the texture is 4 % of an emblem
        window.item("//Warp/Export view…").wait(3)
        window.context.item_input_value("//Export the view/##name", str(tmp_path / "view.png"))
        window.wait_until(lambda: (tmp_path / "view.png").exists() and editor.jobs.is_idle)
        view = load(tmp_path / "view.png").pixels
        assert view.shape == (1024, 1024, 4)
        assert 0.1 < (view[..., 3] > 127).mean() < 0.9
        window.key(imgui.Key.mod_ctrl, imgui.Key.z).wait(3)
        assert editor.document.surface is None

    drive(editor, script)


def test_a_mesh_is_named_whatever_it_is_called(editor: Editor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_obj(tmp_path / "sphere.obj", mug())
    said: list[str] = []

    def note_chosen(name: str, choices: Sequence[tuple[str, str, str]], chosen: str) -> str | None:
        said.append(chosen)
        return segments(name, choices, chosen)

    monkeypatch.setattr("app.ui.panels.space.faint", said.append)
    monkeypatch.setattr("app.ui.panels.space.segments", note_chosen)

    def script(window: WindowDriver) -> None:
        window.item("//Warp/In space##page").wait(2)
        for surface, chosen in ((read_mesh(tmp_path / "sphere.obj"), ""), (make_shape("sphere"), "sphere")):
            editor.edit("Surface", editor.document.changed(surface=surface))
            window.wait(3)
            said.clear()
            window.wait(3)
            assert chosen in said
            assert ("sphere" in said) is bool(chosen)
            assert any(text.startswith("On the mesh sphere.") for text in said) is not bool(chosen)

    drive(editor, script)


def test_what_is_painted_shows_on_the_surface_while_the_canvas_shows_the_picture_as_it_was(
    editor: Editor, tmp_path: Path
) -> None:
    picture, _ = label()
    save(Image(picture), tmp_path / "label.png")

    def script(window: WindowDriver) -> None:
        def shoot() -> list[Floats]:
            """Return the pixels of both views."""
            shot = window.move(5, 5).screenshot(tmp_path / "views.png").astype(float)
            views = [window.context.item_info(f"//In space/{view}").rect_full for view in ("Plain", "Features kept")]
            return [shot[int(v.min.y) : int(v.max.y), int(v.min.x) : int(v.max.x)] for v in views]

        open_picture(window, tmp_path / "label.png")
        window.item("//Warp/In space##page").wait(2).item("//Warp/Cylinder##shapes0")
        window.wait_until(lambda: editor.document.surface is not None)
        settle(window)
        before = shoot()
        editor.choose_tool("brush")
        x, y = window.shell.workspace.canvas.area.size
        window.drag((x / 2, y / 2), (x / 2 + 20, y / 2 + 20)).wait(2)
        assert editor.unwarped.is_shown
        settle(window)
        plain, kept = shoot()
        assert np.abs(plain - before[0]).mean() < 0.5
        assert np.abs(kept - before[1]).max() > 60
        assert np.abs(kept - before[1]).mean() < 25
        window.item("//Warp/Sphere##shapes0")
        window.wait_until(lambda: editor.document.surface is not None and editor.document.surface.name == "sphere")
        window.wait(2)
        assert not editor.unwarped.is_shown

    drive(editor, script)


def test_shapes_are_chosen_shaped_and_taken_back(editor: Editor, tmp_path: Path) -> None:
    picture, _ = label()
    save(Image(picture), tmp_path / "label.png")

    def script(window: WindowDriver) -> None:
        open_picture(window, tmp_path / "label.png")
        window.item("//Warp/In space##page").wait(2)
        window.item("//Warp/Sphere##shapes0")
        window.wait_until(lambda: editor.document.surface is not None and editor.document.surface.name == "sphere")
        settle(window)
        assert editor.document.canvas_px == editor.document.surface.chart.size_px(SIZE)  # type: ignore[union-attr]
        window.item("//Warp/Cone##shapes3")
        window.wait_until(lambda: editor.document.surface is not None and editor.document.surface.name == "cone")
        settle(window)
        area = window.shell.workspace.canvas.area
        for view in ("Plain", "Features kept"):
            shown = window.context.item_info(f"//In space/{view}").rect_full
            assert shown.max.x <= area.x  # beside the canvas, not over it
            assert shown.max.y <= area.y + area.height
        window.context.mouse_move("//In space/Plain")
        window.context.mouse_wheel_y(3.0)
        window.wait(3)
        assert editor.session.orbit.zoom > 1
        window.context.item_double_click("//In space/Plain")
        window.wait(3)
        assert editor.session.orbit == Orbit()
        window.item("//Warp/Lay flat").wait(3)
        assert editor.document.surface is None
        assert editor.document.canvas_px == SIZE

    drive(editor, script)
