"""What was found of a cloth stays: protected parts, a reopened project, a find that a worse one would replace."""

import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.document.document import Document
from core.document.overlay import OverlayLayers, get_layers
from core.document.overlay_texture import lay_on
from core.document.project import load_project, save_project
from core.files.text import begin_sentence
from core.imaging.images import Image
from core.notices import hear_notices
from core.overlay import decomposition
from core.overlay.found_cloth import FoundCloth
from core.progress import Job, Progress
from core.rasters.raster import Raster
from tests.app.overlay.driver import PHOTO, TEXTURE, OverlayDriver


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
