"""What was found of a cloth stays: protected parts, a reopened project, a find that a worse one would replace."""

import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.model.jobs import InlineExecutor, Jobs
from core.document.document import Document, pixels_from_places
from core.document.overlay import get_layers
from core.document.overlay_layers import OverlayLayers, vertices_of
from core.document.overlay_settings import LatticeVertices, Mending, Search
from core.document.overlay_texture import lay_on
from core.document.project import load_project, save_project
from core.files.text import begin_sentence
from core.imaging.images import Image
from core.notices import hear_notices
from core.overlay import decomposition
from core.overlay.found_cloth import FoundCloth
from core.progress import Job, Progress
from core.rasters.raster import Raster
from tests.app.driver import EditorDriver, Later
from tests.app.overlay.driver import PHOTO, TABLE, TEXTURE, OverlayDriver


def layers_of(document: Document) -> OverlayLayers:
    layers = get_layers(document)
    assert layers is not None
    return layers


def test_protected_parts_keep_the_photo_by_their_grey_levels(drive: OverlayDriver) -> None:
    drive.editor.edit("Texture", drive.document.with_cloth(texture=TEXTURE))
    levels = np.zeros((130, 150), np.uint8)
    levels[40:60, 40:60], levels[80:100, 80:100] = 255, 128
    document = drive.document.with_cloth(protected=Raster.from_array(levels))
    layers = layers_of(document)
    plain, kept = (lay_on(PHOTO, layers, cloth).pixels.astype(int) for cloth in (drive.cloth, document.cloth))
    photo = PHOTO.pixels.astype(int)
    np.testing.assert_array_equal(kept[40:60, 40:60], photo[40:60, 40:60])
    assert np.abs(plain - photo)[40:60, 40:60].mean() > 10
    half = slice(80, 100), slice(80, 100)
    assert np.abs(kept[half] - (plain[half] + photo[half]) / 2).mean() < 1
    np.testing.assert_array_equal(kept[levels == 0], plain[levels == 0])


def test_second_brush_paints_what_is_protected_and_searches_nothing(drive: OverlayDriver) -> None:
    before = drive.editor.overlay.layers
    drive.run("overlay.paint_protected").drag((50, 50), (52, 50))
    protected = drive.cloth.protected
    assert protected is not None
    assert protected.array[50, 50] == 255
    assert drive.cloth.region is None
    assert drive.labels == ("Paint protection",)
    assert drive.editor.overlay.layers is before
    assert drive.editor.overlay.is_final
    drive.run("overlay.clear_protected")
    assert drive.cloth.protected is None
    drive.run("overlay.paint_region").drag((50, 50), (52, 50))
    assert drive.cloth.region is not None


def test_what_is_painted_as_cover_is_laid_and_searches_nothing(
    drive: OverlayDriver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(decomposition, "decompose", never)
    drive.editor.edit("Texture", drive.document.with_cloth(texture=TEXTURE))
    drive.editor.edit("Removed", without_vertices(drive, (75, 65)))
    drive.frame()
    before = drive.editor.overlay.layers
    assert before is not None
    assert not before.covered[65, 75]
    size = before.usual_size
    drive.run("overlay.paint_covered").press(75, 65).move(77, 65)
    assert drive.editor.overlay.layers is before
    assert not drive.editor.overlay.is_final
    assert not drive.editor.overlay.is_stopped, "it waits for the end of the stroke"
    drive.release().frame()
    layers, cover = drive.editor.overlay.layers, drive.cloth.covered
    assert layers is not None
    assert cover is not None
    assert drive.labels[-1] == "Paint cover"
    assert drive.editor.overlay.is_final
    assert layers.covered[65, 75]
    assert layers.coverage[65, 75] == 1
    assert layers.usual_size == size
    np.testing.assert_array_equal(layers.middle, before.middle)
    np.testing.assert_array_equal(layers.uv[before.covered], before.uv[before.covered])
    laid = lay_on(PHOTO, layers, drive.cloth).pixels
    assert np.abs(laid[65, 75].astype(int) - PHOTO.pixels[65, 75]).max() > 10
    save_project(drive.document, tmp_path / "a.weft")
    again = OverlayDriver(load_project(tmp_path / "a.weft"))
    reopened = again.editor.overlay.layers
    assert reopened is not None
    np.testing.assert_array_equal(reopened.uv, layers.uv)
    drive.editor.undo()
    drive.frame()
    assert drive.editor.overlay.layers is before
    drive.editor.redo()
    drive.frame()
    drive.run("overlay.clear_covered")
    assert drive.cloth.covered is None
    assert drive.editor.overlay.layers is before


def without_vertices(drive: OverlayDriver, around: tuple[float, float]) -> Document:
    """Return the document with the vertices within 30 pixels of a place removed."""
    search = drive.cloth.search
    assert search is not None
    known = vertices_of(drive.document, layers_of(drive.document))
    points = pixels_from_places(drive.document.size_px, known.places)
    kept = np.linalg.norm(points - around, axis=1) > 30
    lattice = LatticeVertices(known.keys[kept], known.places[kept])
    mending = Mending(search, lattice, np.empty((0, 2)), (), known.places[~kept])
    return drive.document.with_cloth(search=replace(search, mending=mending))


def test_painting_cover_does_not_stop_a_search() -> None:
    jobs = Jobs(live=InlineExecutor(), long=(later := Later()), beside=InlineExecutor())
    drive = EditorDriver(Document.of(PHOTO).changed(mode="overlay"), jobs=jobs)
    drive.editor.edit("Find pattern", drive.document.with_cloth(search=Search()))
    ticket = drive.frame().editor.overlay.ticket
    assert ticket is not None
    assert TABLE.run("overlay.paint_covered", drive.editor)
    drive.drag((75, 65), (77, 65))
    assert not ticket.cancelled
    later.run()
    overlay = drive.frame().editor.overlay
    assert overlay.layers is not None
    assert not overlay.is_final
    later.run()
    drive.frame()
    assert overlay.is_final
    assert overlay.ticket is not None
    assert overlay.ticket.name == "Cover"
    assert overlay.layers.uncovered is not None


def test_reopened_project_shows_its_result_without_a_search(
    drive: OverlayDriver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(decomposition, "decompose", never)
    save_project(drive.document, tmp_path / "a.weft")
    again = OverlayDriver(load_project(tmp_path / "a.weft"))
    layers, before = again.editor.overlay.layers, drive.editor.overlay.layers
    assert layers is not None
    assert before is not None
    assert again.editor.overlay.is_final
    for name in ("uv", "shading", "detail", "bare_detail", "coverage", "texel"):
        np.testing.assert_array_equal(getattr(layers, name), getattr(before, name), err_msg=name)
    np.testing.assert_array_equal(layers.lattice.keys, before.lattice.keys)
    assert layers.explained == before.explained


def never(*_: object, **__: object) -> Job[None]:
    pytest.fail("a search was begun")
    yield Progress(0.0)


def test_damaged_result_is_told_and_looked_for_anew(drive: OverlayDriver, tmp_path: Path) -> None:
    save_project(drive.document, tmp_path / "a.weft")
    with zipfile.ZipFile(tmp_path / "a.weft") as whole, zipfile.ZipFile(tmp_path / "b.weft", "w") as damaged:
        for name in whole.namelist():
            damaged.writestr(name, whole.read(name)[: 1000 if name == "layers/uv.npy" else None])
    with hear_notices() as notices:
        document = load_project(tmp_path / "b.weft")
    assert get_layers(document) is None
    assert document.cloth.search is not None
    fault = "uv: is cut short, or not as large as it says"
    assert notices == [f"b.weft: what was found of the cloth is damaged, and is looked for anew: {fault}"]


def test_whole_cloth_never_replaces_a_better_find_by_a_worse_one(
    found: Document, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive = OverlayDriver(found)
    before, search = drive.editor.overlay.layers, drive.cloth.search
    assert before is not None

    def whole(image: Image, _: object) -> Job[object]:
        yield Progress(0.0)
        return np.ones((image.height_px, image.width_px), bool)

    def follow(found: FoundCloth, *_: object, **__: object) -> Job[FoundCloth]:
        yield Progress(0.0)
        worse = replace(found)
        worse.__dict__["explained"] = found.explained - 1
        return worse

    monkeypatch.setattr(decomposition, "whole_object", whole)
    monkeypatch.setattr(decomposition, "follow", follow)
    drive.run("overlay.whole").frame()
    assert begin_sentence(decomposition.NO_BETTER) in drive.editor.notices[-1].text
    assert drive.cloth.search is search
    assert drive.editor.overlay.layers is before
