from pathlib import Path

import cv2
import numpy as np
import pytest

from app.actions.table import ActionTable
from app.files import masks
from app.marking.feature_list import rows_of
from app.model.jobs import InlineExecutor, Jobs
from app.model.requests import OpenFile, SaveFile
from app.tools.all import TOOLS
from core.arrays import Bytes
from core.document.document import Document
from core.document.project import save_project
from core.imaging.images import Image, load, save
from core.rasters.raster import Raster
from core.selection.features import parts_of
from tests.app.driver import EditorDriver, Later, document

TABLE = ActionTable(TOOLS)


@pytest.fixture
def drive() -> EditorDriver:
    return EditorDriver()


def act(drive: EditorDriver, *names: str) -> None:
    for name in names:
        TABLE.by_name[name].try_run(drive.editor)
        drive.frame()


def disc(radius_px: int) -> Bytes:
    mask = np.zeros((150, 200), np.uint8)
    return np.asarray(cv2.circle(mask, (100, 75), radius_px, (255,), -1), np.uint8)


def disc_on_ground() -> Document:
    """Return a document with a red disc of radius 40 in its middle, and with rough paint over it."""
    noise = np.random.default_rng(0).integers(0, 40, (150, 200, 3))
    colours = np.where(disc(40)[..., None] > 0, (190, 40, 30), (40, 150, 180))
    rough = Raster.from_array(disc(48))
    return Document.of(Image((colours + noise).astype(np.uint8))).with_warp(cell_px=8.0).changed(mask=rough)


def test_a_mask_is_loaded_and_undone(drive: EditorDriver, tmp_path: Path) -> None:
    mask = np.zeros((150, 200, 1), np.uint8)
    mask[10:20] = 255
    save(Image(mask), tmp_path / "mask.png")
    masks.ask_mask(drive.editor)
    request = drive.editor.requests.pop()
    assert isinstance(request, OpenFile)
    request.then(tmp_path / "mask.png")
    drive.frame()
    assert np.array_equal(drive.document.mask.array, mask[..., 0])
    assert drive.undo().document is drive.start


def halves() -> Document:
    """Return the document with the disc, roughly painted as two features that touch."""
    start = disc_on_ground()
    numbers = np.where(start.mask.array > 0, np.where(np.arange(200) < 100, 1, 2), 0).astype(np.uint8)
    return start.changed(mask=Raster.from_array(disc(30)), numbers=Raster.from_array(numbers * (disc(30) > 0)))


@pytest.mark.parametrize("change", ["mask.grow", "mask.fit", "stroke", "selection"])
def test_what_is_added_to_features_belongs_to_them(change: str) -> None:
    drive = EditorDriver(halves())
    if change == "stroke":
        drive.tool("brush").drag((80, 75), (60, 75))
    elif change == "selection":
        drive.tool("rectangle").drag((80, 60), (40, 90))
    else:
        act(drive, change)
    document = drive.document
    assert document.mask is not drive.start.mask
    assert document.numbers is not None
    parts = parts_of(document.mask.array, document.numbers.array)
    assert set(np.unique(parts)) == {0, 1, 2}
    assert (parts[75, 68:99] == 1).all()
    assert drive.undo().document is drive.start


def test_a_loaded_mask_and_one_from_transparency_have_features_of_their_own(tmp_path: Path) -> None:
    save(Image(disc(40)[..., None]), tmp_path / "mask.png")
    clear = Image(np.dstack([halves().image.pixels, disc(40)]))
    drive = EditorDriver(halves().changed(image=clear))
    masks.load_mask_from(drive.editor, tmp_path / "mask.png")
    assert drive.frame().document.numbers is None
    drive.undo()
    masks.mark_opaque(drive.editor)
    assert drive.frame().document.numbers is None


def test_a_mask_of_another_size_is_refused_but_a_projects_mask_is_resized(drive: EditorDriver, tmp_path: Path) -> None:
    save(Image(np.zeros((20, 20, 1), np.uint8)), tmp_path / "mask.png")
    masks.load_mask_from(drive.editor, tmp_path / "mask.png")
    drive.frame()
    assert drive.document is drive.start
    other = document(100, 75)
    save_project(other.changed(mask=other.mask.inverted), tmp_path / "other.weft")
    masks.load_mask_from(drive.editor, tmp_path / "other.weft")
    drive.frame()
    assert drive.mask.min() == 255


def test_a_mask_is_saved_and_loads_again(tmp_path: Path) -> None:
    drive = EditorDriver(disc_on_ground())
    act(drive, "mask.save")
    request = drive.editor.requests.pop()
    assert isinstance(request, SaveFile)
    assert request.suggested.name == "Untitled-mask.png"
    request.then(tmp_path / "mine.png")
    drive.frame()
    assert drive.editor.notices[-1].text == "Saved mine.png"
    assert load(tmp_path / "mine.png").channels == 1
    act(drive, "mask.clear")
    masks.load_mask_from(drive.editor, tmp_path / "mine.png")
    drive.frame()
    assert np.array_equal(drive.document.mask.array, drive.start.mask.array)


def test_rough_paint_becomes_the_objects_mask_in_one_step() -> None:
    drive = EditorDriver(disc_on_ground())
    act(drive, "mask.fit")
    assert np.mean((drive.document.mask.array > 127) != (disc(40) > 0)) < 0.01
    assert drive.labels[-1] == "Fit mask to objects"
    assert drive.undo().document is drive.start


def test_strokes_on_two_objects_that_touch_stay_two_features_when_they_are_fitted() -> None:
    objects, rough = np.zeros((150, 200), np.uint8), np.zeros((150, 200), np.uint8)
    for x in (70, 128):
        cv2.circle(objects, (x, 75), 30, (255,), -1)
        cv2.circle(rough, (x, 75), 26, (255,), -1)
    noise = np.random.default_rng(0).integers(0, 40, (150, 200, 3))
    colours = np.where(objects[..., None] > 0, (190, 40, 30), (40, 150, 180))
    start = Document.of(Image((colours + noise).astype(np.uint8))).with_warp(cell_px=8.0)
    drive = EditorDriver(start.changed(mask=Raster.from_array(rough)))
    names = [(row.name, row.box[0] < 90) for row in rows_of(drive.editor)]
    act(drive, "mask.fit")
    document = drive.document
    assert document.numbers is not None
    fitted = document.mask.array > 127
    assert cv2.connectedComponents(fitted.astype(np.uint8))[0] == 2  # one blob
    assert np.mean(fitted != (objects > 0)) < 0.01
    parts = parts_of(document.mask.array, document.numbers.array)
    assert (parts[75, 45:95] == 1).all()
    assert (parts[75, 103:155] == 2).all()
    assert [(row.name, row.box[0] < 90) for row in rows_of(drive.editor)] == names
    assert "apart" in drive.editor.notices[-1].text
    assert drive.undo().document.numbers is None


def test_what_is_painted_meanwhile_is_not_overwritten() -> None:
    work = Later()
    jobs = Jobs(live=InlineExecutor(), long=work, beside=InlineExecutor())
    drive = EditorDriver(disc_on_ground(), jobs=jobs)
    act(drive, "mask.fit")
    act(drive, "mask.invert")
    work.run()
    drive.frame()
    assert drive.labels[-1] == "Invert mask"


def test_masks_of_texture_are_fitted_too_but_neither_matte_nor_region() -> None:
    rough = disc_on_ground().mask
    drive = EditorDriver(disc_on_ground().with_cloth(region=rough).changed(matte=rough, source_mask=rough))
    act(drive, "mode.retexture", "retexture.paint_source_mask", "mask.fit")
    assert drive.document.source_mask is not None
    assert np.mean((drive.document.source_mask.array > 127) != (disc(40) > 0)) < 0.01
    act(drive, "retexture.paint_matte", "mask.fit")
    assert drive.document.matte is rough
    act(drive, "mode.overlay", "mask.fit")
    assert drive.document.cloth.region is rough


def letters() -> Document:
    """Return a transparent picture with three opaque bars, the middle one with a soft edge."""
    pixels = np.zeros((150, 200, 4), np.uint8)
    for left in (20, 80, 140):
        pixels[40:110, left : left + 40] = 255
    pixels[40:110, 79, 3] = 90
    return Document.of(Image(pixels)).with_warp(cell_px=8.0)


def test_each_letter_of_a_transparent_picture_is_a_feature() -> None:
    drive = EditorDriver(letters())
    act(drive, "mask.transparency")
    assert drive.labels == ("Mask from transparency",)
    assert np.array_equal(drive.document.mask.array, drive.document.image.pixels[..., 3])
    features = drive.editor.answer.features
    assert features is not None
    assert len(features) == 3


def test_fitting_on_a_transparent_picture_takes_what_is_opaque_under_the_paint() -> None:
    start = letters()
    rough = np.zeros((150, 200), np.uint8)
    rough[60:70, 90:150] = 255
    drive = EditorDriver(start.changed(mask=Raster.from_array(rough)))
    act(drive, "mask.fit")
    alpha = start.image.pixels[..., 3]
    assert np.array_equal(drive.document.mask.array[:, 70:], alpha[:, 70:])
    assert not drive.document.mask.array[:, :70].any()
    drive.editor.edit("Between", start.changed(mask=Raster.from_array(np.where(alpha > 0, 0, 255).astype(np.uint8))))
    act(drive, "mask.fit")
    assert drive.editor.notices[-1].text == "Nothing is painted over but what is transparent"


def test_a_picture_without_transparency_says_so(drive: EditorDriver) -> None:
    assert not TABLE.by_name["mask.transparency"].enabled(drive.editor)
    masks.mark_opaque(drive.editor)
    assert drive.editor.notices[-1].text == "The picture has no transparency to tell objects by"
    assert drive.document is drive.start


def test_labels_that_are_loaded_are_features_of_their_own(drive: EditorDriver, tmp_path: Path) -> None:
    labels = np.zeros((150, 200, 1), np.uint8)
    labels[20:100, 20:80], labels[20:100, 80:120] = 2, 9
    save(Image(labels), tmp_path / "labels.png")
    masks.load_mask_from(drive.editor, tmp_path / "labels.png")
    drive.frame()
    assert drive.editor.notices[-1].text == "The mask holds 2 labels, each of them a feature."
    features = drive.editor.answer.features
    assert features is not None
    assert features.ids.tolist() == [1, 2]
    assert drive.document.mask.array[50, 100] == 255
    act(drive, "mask.clear")
    assert drive.document.numbers is None
    assert drive.undo().document.numbers is not None
