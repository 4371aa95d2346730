"""Stories of Overlay mode: a texture is laid on the cloth, what was found is shown, the result written."""

from pathlib import Path

import numpy as np
import pytest

from app.actions import dropped, overlay
from app.cli import main
from app.files import document_io
from app.model.jobs import InlineExecutor, Jobs
from app.model.requests import ExportOptions, ExportPicture, OpenFile, SaveFile
from app.model.shapes import Polyline
from app.render.picture_file import exporting
from app.tools.marks import marks
from core.arrays import InputError
from core.document.document import Document
from core.document.overlay_settings import Search
from core.document.overlay_texture import lay_on, layers_under, placement_of, size_of
from core.document.project import load_project, save_project
from core.imaging.images import Image, load, save
from core.overlay import decomposition
from core.progress import run
from tests.app.driver import EditorDriver, Later
from tests.app.overlay.driver import PHOTO, TEXTURE, OverlayDriver


def answer(drive: EditorDriver, path: Path) -> None:
    """Answer the newest question for a file."""
    request = drive.editor.requests.pop()
    assert isinstance(request, OpenFile | SaveFile)
    request.then(path)
    drive.frame()


def test_dropped_file_is_laid_into_the_folds(drive: OverlayDriver, tmp_path: Path) -> None:
    save(TEXTURE, tmp_path / "new.png")
    dropped.take(drive.editor, tmp_path / "new.png")
    drive.frame()
    assert drive.cloth.texture is not None
    assert drive.cloth.texture_name == "new.png"
    assert drive.document.image is PHOTO
    drive.run("overlay.old_pattern")
    assert drive.cloth.texture is None


def test_dropped_file_is_opened_while_no_pattern_is_found(tmp_path: Path) -> None:
    drive = OverlayDriver(Document.of(PHOTO))
    save(TEXTURE, tmp_path / "new.png")
    dropped.take(drive.editor, tmp_path / "new.png")
    drive.frame()
    assert drive.document.size_px == (80, 60)


def test_texture_goes_with_the_pointer(drive: OverlayDriver) -> None:
    drive.editor.edit(
        "Texture", drive.document.changed(cloth=drive.cloth.changed(texture=TEXTURE).with_laying(upright=False))
    )
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
    drive.editor.slide("Detail", drive.document.changed(cloth=drive.cloth.with_laying(detail=0.3)))
    drive.frame().editor.finish()
    assert drive.editor.overlay.layers is before
    assert drive.labels == ("Detail",)


def test_project_keeps_what_was_done_and_finds_the_rest_again(drive: OverlayDriver, tmp_path: Path) -> None:
    cloth = drive.cloth.changed(texture=TEXTURE, texture_name="new.png").with_laying(size=3.0, mirror=True)
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
    document_io.export(drive.editor, ExportOptions(plain, drive.document.size_px))
    drive.frame()
    difference = load(plain).pixels.astype(int) - PHOTO.pixels
    assert np.abs(difference).max() <= 1
    drive.editor.edit("Texture", drive.document.with_cloth(texture=TEXTURE))
    document_io.ask_export(drive.editor)
    request = drive.editor.requests.pop()
    assert isinstance(request, ExportPicture)
    assert request.options.size_px == drive.document.size_px
    document_io.export(drive.editor, ExportOptions(tmp_path / "deep.png", drive.document.size_px, bits=16))
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


def test_dropped_picture_is_a_texture_at_once_while_the_pattern_is_looked_for(tmp_path: Path) -> None:
    save(TEXTURE, tmp_path / "new.png")
    jobs = Jobs(live=InlineExecutor(), long=(later := Later()), beside=InlineExecutor())
    drive = EditorDriver(Document.of(PHOTO).changed(mode="overlay"), jobs=jobs)
    drive.editor.edit("Find pattern", drive.document.with_cloth(search=Search()))
    drive.frame()
    dropped.take(drive.editor, tmp_path / "new.png")
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
    drive.editor.edit("Size", drive.document.changed(cloth=drive.cloth.with_laying(size=7.0)))
    overlay.lay(drive.editor, tmp_path / "new.png")
    assert size_of(layers, drive.frame().document.cloth.laying) == 7.0


def test_rendering_a_project_finds_the_pattern_again(drive: OverlayDriver, tmp_path: Path) -> None:
    drive.editor.edit("Texture", drive.document.with_cloth(texture=TEXTURE))
    save_project(drive.document, tmp_path / "project.weft")
    assert main(["render", str(tmp_path / "project.weft"), "-o", str(tmp_path / "out.png")]) == 0
    written = load(tmp_path / "out.png").pixels
    layers = drive.editor.overlay.layers
    assert layers is not None
    expected = lay_on(PHOTO, layers, drive.cloth).pixels
    assert np.abs(written.astype(int) - expected).max() <= 1


def test_what_was_found_is_seen_until_a_texture_lies_on_it(drive: OverlayDriver) -> None:
    drive.tool("drape")
    assert any(isinstance(shape, Polyline) and shape.role == "lattice" for shape in marks(drive.editor))
    cloth = drive.cloth.changed(texture=TEXTURE)
    drive.editor.edit("Texture", drive.document.changed(cloth=cloth))
    assert marks(drive.editor) == []
    drive.undo()
    assert marks(drive.editor) != []
    drive.editor.edit("Upright", drive.document.changed(cloth=cloth.with_laying(upright=False)))
    layers = drive.editor.overlay.layers
    assert layers is not None
    assert not placement_of(layers, TEXTURE, drive.cloth.laying).upright


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


def test_a_photo_on_which_nothing_is_laid_stays_as_it_is(drive: OverlayDriver) -> None:
    layers = drive.editor.overlay.layers
    assert layers is not None
    assert lay_on(PHOTO, layers, drive.cloth) is PHOTO
    fainter = lay_on(PHOTO, layers, drive.cloth.with_laying(detail=0.0))
    assert np.abs(fainter.pixels.astype(int) - PHOTO.pixels).max() > 10


def test_an_export_without_a_pattern_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    noise = Image(np.random.default_rng(5).integers(0, 256, (90, 110, 3), np.uint8))
    document = Document.of(noise).changed(mode="overlay")
    options = ExportOptions(tmp_path / "out.png", noise.size_px)
    run(exporting(document, options))
    textured = document.with_cloth(texture=TEXTURE, texture_name="new.png")
    with pytest.raises(InputError, match="no pattern was found yet that a texture could take the place of"):
        run(exporting(textured, options))
    drive = OverlayDriver(textured.with_cloth(search=Search()))
    assert drive.editor.overlay.fault == "no repeating texture found in the picture"
    # It is known by now, and nothing is looked for again.
    monkeypatch.setattr(decomposition, "decompose", lambda *_, **__: pytest.fail("a search of its own"))
    with pytest.raises(InputError, match="no repeating texture found in the picture"):
        run(exporting(drive.document, options))
