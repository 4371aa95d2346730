"""Stories of Overlay mode: a pattern is found, a texture laid on, the lattice mended, the result written."""

from pathlib import Path

import numpy as np
import pytest

from app import filing
from app.actions import overlay
from app.actions.table import ActionTable
from app.cli import main
from app.editor import Editor
from app.jobs import InlineExecutor, Jobs
from app.render.picture_file import exporting
from app.requests import ExportOptions, ExportPicture, OpenFile, SaveFile
from app.shapes import Polyline
from app.tools.all import TOOLS
from app.tools.lattice import free_key, lattice_shapes, on_screen, remove, vertices
from app.tools.marks import marks
from core import color
from core.arrays import Bools
from core.cloth import Cloth, LatticeVertices, Search
from core.document import Document
from core.document_overlay import laid_on, layers_under, placement_of, size_of
from core.images import Image, load, save
from core.overlay.detection.seeding import NoPatternError
from core.project import load_project, save_project
from tests.app.driver import EditorDriver, Later, picture
from tests.core.overlay_scenes import make_scene, motif

TABLE = ActionTable(TOOLS)
SCENE = make_scene(motif(), size=(130, 150))
PHOTO = Image(color.quantise(SCENE.photo.astype(np.float32), np.uint8))
TEXTURE = picture(80, 60)


class OverlayDriver(EditorDriver):
    def __init__(self, start: Document) -> None:
        super().__init__(start)
        self.editor.choose_mode("overlay")
        self.frame()

    def run(self, name: str) -> "OverlayDriver":
        assert TABLE.run(name, self.editor)
        self.frame()
        return self

    @property
    def cloth(self) -> Cloth:
        return self.document.cloth


def answer(drive: EditorDriver, path: Path) -> None:
    """Answer the newest question for a file."""
    request = drive.editor.requests.pop()
    assert isinstance(request, OpenFile | SaveFile)
    request.then(path)
    drive.frame()


@pytest.fixture(scope="module")
def found() -> Document:
    """Return a document whose pattern is found; the editors of this file share what was found."""
    return OverlayDriver(Document.of(PHOTO)).run("overlay.find").document


@pytest.fixture
def drive(found: Document) -> OverlayDriver:
    drive = OverlayDriver(found)
    assert drive.editor.overlay.is_final
    return drive


def test_pattern_is_found_and_undone(drive: OverlayDriver) -> None:
    fresh = OverlayDriver(Document.of(PHOTO))
    assert fresh.editor.overlay.layers is None
    fresh.editor.edit("Find pattern", fresh.document.with_cloth(search=drive.cloth.search))
    layers = fresh.frame().editor.overlay.layers
    assert layers is not None
    assert layers.covered.mean() > 0.8
    assert layers.covered_share == pytest.approx(layers.covered.mean())
    fresh.undo()
    assert fresh.editor.overlay.layers is None
    fresh.redo()
    assert fresh.editor.overlay.layers is layers


def test_picture_without_pattern_is_refused_in_words() -> None:
    noise = np.random.default_rng(0).integers(0, 255, (60, 70, 3)).astype(np.uint8)
    drive = OverlayDriver(Document.of(Image(noise))).run("overlay.find")
    assert drive.editor.overlay.layers is None
    assert drive.editor.fault == str(NoPatternError("the picture"))
    assert not drive.editor.overlay.is_running


def test_dropped_file_is_laid_into_the_folds(drive: OverlayDriver, tmp_path: Path) -> None:
    save(TEXTURE, tmp_path / "new.png")
    overlay.open_or_lay(drive.editor, tmp_path / "new.png")
    drive.frame()
    assert drive.cloth.texture is not None
    assert drive.cloth.texture_name == "new.png"
    assert drive.document.image is PHOTO
    drive.run("overlay.old_pattern")
    assert drive.cloth.texture is None


def test_dropped_file_is_opened_while_no_pattern_is_found(tmp_path: Path) -> None:
    drive = OverlayDriver(Document.of(PHOTO))
    save(TEXTURE, tmp_path / "new.png")
    overlay.open_or_lay(drive.editor, tmp_path / "new.png")
    drive.frame()
    assert drive.document.size_px == (80, 60)


def test_texture_goes_with_the_pointer(drive: OverlayDriver) -> None:
    drive.editor.edit("Texture", drive.document.changed(cloth=drive.cloth.changed(texture=TEXTURE).laid(upright=False)))
    drive.tool("drape")
    layers = drive.editor.overlay.layers
    assert layers is not None
    start, end = (60.0, 60.0), (66.0, 63.0)
    drive.drag(start, (63.0, 61.0), end)
    texture = np.array(drive.cloth.laying.offset)
    moved = layers.uv[63, 66] - layers.uv[60, 60]
    across, down = np.linalg.norm(layers.basis, axis=0)
    repeat = np.array([1, down / across * 80 / 60]) / layers.usual_size
    np.testing.assert_allclose(texture, repeat * moved, atol=1e-5)
    drive.drag(start, (80.0, 60.0), shift=True)
    assert drive.cloth.laying.rotate_deg == pytest.approx(8.0)
    drive.undo().undo()
    assert drive.cloth.laying.offset == (0.0, 0.0)


def test_new_texture_goes_with_the_detail_that_is_free_of_the_old_pattern(drive: OverlayDriver) -> None:
    layers = drive.editor.overlay.layers
    assert layers is not None
    inside = layers.covered
    roughness = [float(np.std(detail[inside])) for detail in (layers.detail, layers.bare_detail)]
    assert roughness[1] < 0.9 * roughness[0]
    assert layers_under(drive.cloth, layers) is layers
    worn = layers_under(drive.cloth.changed(texture=TEXTURE), layers)
    assert worn.detail is layers.bare_detail
    assert layers_under(drive.cloth.changed(texture=TEXTURE), layers) is worn


def test_slider_needs_no_job(drive: OverlayDriver) -> None:
    before = drive.editor.overlay.layers
    drive.editor.slide("Detail", drive.document.changed(cloth=drive.cloth.laid(detail=0.3)))
    drive.frame().editor.finish()
    assert drive.editor.overlay.layers is before
    assert drive.labels == ("Detail",)


def test_moved_vertex_is_where_the_pattern_is_found_from(drive: OverlayDriver) -> None:
    drive.tool("lattice")
    lattice = vertices(drive.editor)
    assert lattice is not None
    places = on_screen(drive.editor, lattice)
    row = int(np.argmin(np.hypot(*(places - (75, 65)).T)))
    x, y = places[row].tolist()
    before = drive.editor.overlay.layers
    drive.move(x, y).press(x, y).move(x + 5, y).move(x + 1, y + 1)
    assert drive.editor.overlay.layers is before
    search = drive.cloth.search
    assert search is not None
    assert search.lattice is not None
    np.testing.assert_allclose(on_screen(drive.editor, search.lattice)[row], (x + 1, y + 1))
    drive.release().frame()
    assert drive.editor.overlay.is_final
    assert drive.editor.overlay.layers is not before
    assert drive.labels == ("Move lattice vertex",)
    drive.undo()
    assert drive.editor.overlay.layers is before


def test_vertex_is_removed_and_has_its_place_again(drive: OverlayDriver) -> None:
    drive.tool("lattice")
    lattice = vertices(drive.editor)
    assert lattice is not None
    places = on_screen(drive.editor, lattice)
    row = int(np.argmin(np.hypot(*(places - (75, 65)).T)))
    x, y = places[row].tolist()
    assert free_key(drive.editor, lattice, (x + 1, y)) is None
    remove(drive.editor, lattice, row)
    search = drive.cloth.search
    assert search is not None
    assert search.lattice is not None
    assert len(search.lattice.keys) == len(lattice.keys) - 1
    assert drive.labels == ("Remove lattice vertex",)
    np.testing.assert_array_equal(free_key(drive.editor, search.lattice, (x + 1, y)), lattice.keys[row])


def test_rectangle_is_the_region_and_is_cut(drive: OverlayDriver) -> None:
    drive.tool("region").drag((20, 20), (50, 60), (90, 80))
    region = drive.cloth.region
    assert region is not None
    assert region.array[50, 50] == 255
    assert (region.array > 0).sum() == pytest.approx(70 * 60, rel=0.05)
    drive.drag((40, 40), (50, 50), (60, 60), alt=True)
    region = drive.cloth.region
    assert region is not None
    assert region.array[50, 50] == 0
    assert drive.labels == ("Region", "Cut from region")
    drive.tool("brush").drag((50, 50), (52, 50))
    region = drive.cloth.region
    assert region is not None
    assert region.array[50, 50] == 255
    assert drive.document.mask.is_empty


def test_marked_texel_is_what_the_pattern_is_found_from() -> None:
    drive = OverlayDriver(Document.of(PHOTO))
    drive.tool("texel").drag((50, 50), (60, 60), (75, 72))
    search = drive.cloth.search
    assert search is not None
    assert search.texel is not None
    np.testing.assert_allclose(np.ptp(np.array(search.texel), axis=0) * drive.document.size_px, (25, 22))
    drive.frame()
    assert drive.editor.overlay.layers is not None


def test_project_keeps_what_was_done_and_finds_the_rest_again(drive: OverlayDriver, tmp_path: Path) -> None:
    cloth = drive.cloth.changed(texture=TEXTURE, texture_name="new.png").laid(size=3.0, mirror=True)
    drive.editor.edit("Texture", drive.document.changed(cloth=cloth))
    save_project(drive.document, tmp_path / "project.weft")
    again = load_project(tmp_path / "project.weft")
    assert again.mode == "overlay"
    assert again.cloth.laying == cloth.laying
    reopened = EditorDriver(again)
    assert reopened.editor.session.mode == "overlay"
    layers, before = reopened.frame().editor.overlay.layers, drive.editor.overlay.layers
    assert layers is not None
    assert before is not None
    np.testing.assert_array_equal(layers.uv, before.uv)


def test_export_has_the_texture_at_the_depth_that_is_asked_for(drive: OverlayDriver, tmp_path: Path) -> None:
    drive.editor.exporter = exporting
    plain = tmp_path / "plain.png"
    filing.export(drive.editor, ExportOptions(plain, drive.document.size_px))
    drive.frame()
    difference = load(plain).pixels.astype(int) - PHOTO.pixels
    assert np.abs(difference).max() <= 1
    drive.editor.edit("Texture", drive.document.with_cloth(texture=TEXTURE))
    filing.ask_export(drive.editor)
    request = drive.editor.requests.pop()
    assert isinstance(request, ExportPicture)
    assert request.options.size_px == drive.document.size_px
    filing.export(drive.editor, ExportOptions(tmp_path / "deep.png", drive.document.size_px, bits=16))
    drive.frame()
    deep = load(tmp_path / "deep.png").pixels
    assert deep.dtype == np.uint16
    assert np.abs(deep / 257 - PHOTO.pixels).mean() > 10


def test_parts_are_shown_and_recombine(drive: OverlayDriver, tmp_path: Path) -> None:
    values = {}
    for part in ("pattern", "mesh", "shading", "detail", "reconstruction", "residual"):
        drive.run(f"shown.{part}")
        shown = drive.editor.overlay.part(drive.document, drive.editor.session.shown)
        assert shown is not None
        assert shown.pixels.shape == PHOTO.pixels.shape
        drive.run(f"overlay.export_{part}")
        answer(drive, tmp_path / f"{part}.exr")
        values[part] = load(tmp_path / f"{part}.exr").pixels
    layers = drive.editor.overlay.layers
    assert layers is not None
    whole = (values["reconstruction"] + values["detail"])[layers.covered]
    np.testing.assert_allclose(whole, PHOTO.pixels[layers.covered] / 255, atol=0.006)


def test_texel_is_saved_as_a_tile(drive: OverlayDriver, tmp_path: Path) -> None:
    drive.run("overlay.save_texel")
    answer(drive, tmp_path / "tile.png")
    layers = drive.editor.overlay.layers
    assert layers is not None
    np.testing.assert_allclose(load(tmp_path / "tile.png").pixels / 255, layers.texel, atol=0.5 / 255)


def test_cancelled_search_goes_on_when_asked_to(found: Document) -> None:
    jobs = Jobs(live=InlineExecutor(), long=(later := Later()), beside=InlineExecutor())
    drive = EditorDriver(Document.of(PHOTO).changed(mode="overlay"), jobs=jobs)
    drive.editor.edit("Find pattern", drive.document.with_cloth(search=Search()))
    drive.frame()
    assert drive.editor.overlay.is_running
    drive.editor.overlay.cancel()
    later.run()
    drive.frame()
    assert drive.editor.overlay.is_stopped
    assert TABLE.run("overlay.go_on", drive.editor)
    drive.frame()
    later.run()
    assert drive.frame().editor.overlay.is_final


def test_dropped_picture_is_a_texture_at_once_while_the_pattern_is_looked_for(tmp_path: Path) -> None:
    save(TEXTURE, tmp_path / "new.png")
    jobs = Jobs(live=InlineExecutor(), long=(later := Later()), beside=InlineExecutor())
    drive = EditorDriver(Document.of(PHOTO).changed(mode="overlay"), jobs=jobs)
    drive.editor.edit("Find pattern", drive.document.with_cloth(search=Search()))
    drive.frame()
    overlay.open_or_lay(drive.editor, tmp_path / "new.png")
    drive.frame()
    assert drive.editor.overlay.is_running
    assert drive.document.image is PHOTO
    assert drive.document.cloth.texture is not None
    later.run()
    layers = drive.frame().editor.overlay.layers
    assert layers is not None
    assert placement_of(layers, TEXTURE, drive.document.cloth.laying).repeat[0] == pytest.approx(1 / 2)


def test_size_suits_the_cloth_until_one_is_chosen(drive: OverlayDriver, tmp_path: Path) -> None:
    save(TEXTURE, tmp_path / "new.png")
    overlay.lay(drive.editor, tmp_path / "new.png")
    layers = drive.frame().editor.overlay.layers
    assert layers is not None
    assert size_of(layers, drive.cloth.laying) == layers.usual_size == 2.0
    drive.tool("drape").drag((60, 60), (70, 60), (80, 60), ctrl=True)
    assert drive.cloth.laying.size == pytest.approx(2 * np.exp(20 / 200))
    drive.editor.edit("Size", drive.document.changed(cloth=drive.cloth.laid(size=7.0)))
    overlay.lay(drive.editor, tmp_path / "new.png")
    assert size_of(layers, drive.frame().document.cloth.laying) == 7.0


def test_rendering_a_project_finds_the_pattern_again(drive: OverlayDriver, tmp_path: Path) -> None:
    drive.editor.edit("Texture", drive.document.with_cloth(texture=TEXTURE))
    save_project(drive.document, tmp_path / "project.weft")
    assert main(["render", str(tmp_path / "project.weft"), "-o", str(tmp_path / "out.png")]) == 0
    written = load(tmp_path / "out.png").pixels
    layers = drive.editor.overlay.layers
    assert layers is not None
    expected = laid_on(PHOTO, layers, drive.cloth).pixels
    assert np.abs(written.astype(int) - expected).max() <= 1


def test_what_was_found_is_seen_until_a_texture_lies_on_it(drive: OverlayDriver) -> None:
    drive.tool("drape")
    assert any(isinstance(shape, Polyline) and shape.role == "lattice" for shape in marks(drive.editor))
    cloth = drive.cloth.changed(texture=TEXTURE)
    drive.editor.edit("Texture", drive.document.changed(cloth=cloth))
    assert marks(drive.editor) == []
    drive.undo()
    assert marks(drive.editor) != []
    drive.editor.edit("Upright", drive.document.changed(cloth=cloth.laid(upright=False)))
    layers = drive.editor.overlay.layers
    assert layers is not None
    assert not placement_of(layers, TEXTURE, drive.cloth.laying).upright


def cloth_on_a_table() -> tuple[Image, Bools]:
    """Return a photo of cloth on something plain, and where (H, W) it is."""
    inside = np.zeros((190, 220), bool)
    inside[30:160, 35:185] = True
    photo = np.random.default_rng(2).normal((60, 75, 90), 3, (190, 220, 3))
    photo[inside] = PHOTO.pixels.reshape(-1, 3)
    return Image(np.clip(photo, 0, 255).astype(np.uint8)), inside


def test_whole_cloth_is_taken_in_and_undone_at_once() -> None:
    photo, inside = cloth_on_a_table()
    drive = OverlayDriver(Document.of(photo))
    drive.tool("region").drag((50, 45), (80, 80), (120, 145))
    drive.run("overlay.find")
    part = drive.editor.overlay.layers
    assert part is not None
    drive.run("overlay.whole").frame()
    region, search = drive.cloth.region, drive.cloth.search
    assert region is not None
    assert search is not None
    assert search.region is region
    taken = region.array > 127
    assert (taken & inside).sum() / (taken | inside).sum() > 0.95
    whole = drive.editor.overlay.layers
    assert whole is not None
    assert whole.covered.sum() > 1.8 * part.covered.sum()
    drive.undo()
    assert drive.editor.overlay.layers is part
    drive.redo()
    drive.run("overlay.whole")
    assert "no more stands out" in drive.editor.notices[-1].text


def test_result_is_seen_once_there_is_something_new_to_see(drive: OverlayDriver, tmp_path: Path) -> None:
    save(TEXTURE, tmp_path / "new.png")
    drive.tool("brush").drag((60, 60), (80, 60))
    overlay.lay(drive.editor, tmp_path / "new.png")
    drive.frame()
    assert drive.editor.session.tool == "drape"
    drive.tool("lattice").editor.show(shown="mesh")
    drive.run("shown.result")
    assert (drive.editor.session.tool, drive.editor.session.shown) == ("drape", "result")
    drive.run("shown.detail").tool("lattice")
    assert drive.editor.session.shown == "detail"


def test_vertex_is_added_only_where_the_lattice_goes_on(drive: OverlayDriver) -> None:
    drive.tool("lattice")
    lattice = vertices(drive.editor)
    assert lattice is not None
    places = on_screen(drive.editor, lattice)
    row = int(np.argmin(np.hypot(*(places - (75, 65)).T)))
    beside = next(n for n, key in enumerate(lattice.keys) if np.array_equal(key, lattice.keys[row] + [1, 0]))
    missing = LatticeVertices(np.delete(lattice.keys, row, axis=0), np.delete(lattice.places, row, axis=0))
    key = free_key(drive.editor, missing, tuple(places[row]))
    np.testing.assert_array_equal(key, lattice.keys[row])
    assert free_key(drive.editor, missing, tuple((places[row] + places[beside]) / 2)) is None


def test_lattice_that_grows_is_shown_in_place_of_the_one_before(found: Document) -> None:
    later = Later()
    editor = Editor(found, TOOLS, jobs=Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
    editor.update()
    before = len(lattice_shapes(editor))
    editor.edit("Find pattern", editor.document.with_cloth(search=Search(seed=1)))
    editor.update()
    assert editor.overlay.is_running
    keys = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
    editor.overlay.stage_lattice = keys, 20.0 * keys + 30
    lines = [shape for shape in lattice_shapes(editor) if isinstance(shape, Polyline)]
    assert before > len(lines) == 4
    assert all(len(line.points) == 2 for line in lines)
    later.run()


def test_a_photo_on_which_nothing_is_laid_stays_as_it_is(drive: OverlayDriver) -> None:
    layers = drive.editor.overlay.layers
    assert layers is not None
    assert laid_on(PHOTO, layers, drive.cloth) is PHOTO
    fainter = laid_on(PHOTO, layers, drive.cloth.laid(detail=0.0))
    assert np.abs(fainter.pixels.astype(int) - PHOTO.pixels).max() > 10
