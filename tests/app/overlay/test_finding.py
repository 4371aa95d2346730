"""Stories of Overlay mode: the pattern is found, in a region or on the whole cloth, and its lattice mended."""

from pathlib import Path

import numpy as np
import pytest

from app.editor.editor import Editor
from app.model.jobs import InlineExecutor, Jobs
from app.model.shapes import Polyline
from app.tools.all import TOOLS
from app.tools.cloth.lattice import lattice_shapes
from core.document import finding_again
from core.document.document import Document
from core.document.overlay import find_layers, get_layers
from core.document.overlay_settings import Search
from core.document.project import load_project, save_project
from core.imaging.images import Image
from core.masks.object_masks import as_bytes
from core.overlay.decomposition import decompose_whole_cloth
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError
from core.overlay.detection.stages import Stage
from core.progress import Progress, run
from core.rasters.raster import Raster
from tests.app.driver import EditorDriver, Later
from tests.app.overlay.driver import PHOTO, TABLE, OverlayDriver, cloth_on_a_table
from tests.core.overlay.prints import print_on_a_table


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


def test_lattice_that_grew_goes_with_a_refusal() -> None:
    later, plain = Later(), Document.of(Image(np.full((90, 120, 3), 128, np.uint8))).changed(mode="overlay")
    editor = Editor(plain, TOOLS, jobs=Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
    editor.edit("Find pattern", editor.document.with_cloth(search=Search(seed=1)))
    editor.update()
    keys = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
    editor.overlay.stage_lattice = keys, 20.0 * keys + 30
    assert len(lattice_shapes(editor)) == 4
    later.run()
    editor.update()
    assert editor.overlay.fault == str(NoPatternError("the picture"))
    assert not lattice_shapes(editor)


def test_picture_without_pattern_is_refused_in_words() -> None:
    noise = np.random.default_rng(0).integers(0, 255, (60, 70, 3)).astype(np.uint8)
    drive = OverlayDriver(Document.of(Image(noise))).run("overlay.find")
    assert drive.editor.overlay.layers is None
    assert drive.editor.fault == str(NoPatternError("the picture"))
    assert not drive.editor.overlay.is_running


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


STROKE = [(50, 45), (80, 80), (120, 145)]
STROKES = [
    pytest.param(STROKE, id="shorter"),
    pytest.param([(48, 43), (80, 80), (125, 150)], id="longer"),
]


@pytest.mark.parametrize("stroke", STROKES)
def test_whole_cloth_is_taken_in_and_undone_at_once(stroke: list[tuple[float, float]]) -> None:
    photo, inside = cloth_on_a_table()
    drive = OverlayDriver(Document.of(photo))
    drive.tool("region").drag(*stroke)
    drive.run("overlay.find")
    part, first = drive.editor.overlay.layers, drive.cloth.search
    assert part is not None
    drive.run("overlay.whole").frame()
    region, search = drive.cloth.region, drive.cloth.search
    whole = drive.editor.overlay.layers
    assert region is not None
    assert search is not None
    assert whole is not None
    assert search.whole_of is first
    taken = region.array > 127
    np.testing.assert_array_equal(taken, whole.covered)
    assert (taken & inside).sum() / (taken | inside).sum() > 0.95
    assert whole.covered.sum() > 1.8 * part.covered.sum()
    drive.undo()
    assert drive.editor.overlay.layers is part
    drive.redo()
    drive.run("overlay.whole")
    assert "No more stands out" in drive.editor.notices[-1].text


def test_whole_cloth_asked_for_at_once_is_what_is_found_where_there_is_no_more() -> None:
    fresh = OverlayDriver(Document.of(PHOTO)).run("overlay.whole")
    layers = fresh.frame().editor.overlay.layers
    assert not fresh.editor.notices
    assert layers is not None
    found = OverlayDriver(Document.of(PHOTO)).run("overlay.find").editor.overlay.layers
    assert found is not None
    np.testing.assert_array_equal(layers.uv, found.uv)
    assert fresh.labels == ("Whole cloth",)


def test_whole_cloth_is_that_of_the_command_line(tmp_path: Path) -> None:
    photo, inside = cloth_on_a_table()
    part = np.zeros(inside.shape, bool)
    part[30:150, 35:130] = True
    found = run(decompose_whole_cloth(photo, region=part))
    before = Document.of(photo).with_cloth(search=Search(Raster.from_array(as_bytes(part))))
    run(find_layers(before))
    # Files of layers do not have the find, which is looked for again.
    save_project(before, tmp_path / "a.weft")
    for document in (before, load_project(tmp_path / "a.weft")):
        whole = document.changed(cloth=run(finding_again.find_whole_cloth(document)))
        layers = get_layers(whole)
        assert layers is not None
        np.testing.assert_array_equal(layers.uv, found.uv)
        np.testing.assert_array_equal(layers.coverage, found.coverage)
        assert layers.covered.sum() > 1.5 * part.sum()


def test_whole_cloth_is_found_again_where_its_layers_are_not_stored(tmp_path: Path) -> None:
    photo, _ = cloth_on_a_table()
    drive = OverlayDriver(Document.of(photo))
    drive.tool("region").drag(*STROKE)
    drive.run("overlay.find").run("overlay.whole").frame()
    whole = drive.editor.overlay.layers
    assert whole is not None
    save_project(drive.document, tmp_path / "a.weft", is_whole=False)
    document = load_project(tmp_path / "a.weft")
    assert get_layers(document) is None
    np.testing.assert_array_equal(run(find_layers(document)).uv, whole.uv)


def test_where_nothing_is_found_what_stands_out_is_taken_for_the_whole_cloth() -> None:
    photo, inside = print_on_a_table()
    drive = OverlayDriver(Document.of(photo)).run("overlay.find")
    assert drive.editor.fault is not None
    assert drive.editor.overlay.layers is None
    drive.run("overlay.whole").frame()
    layers, region = drive.editor.overlay.layers, drive.cloth.region
    assert layers is not None
    assert region is not None
    assert layers.covered[inside].mean() > 0.95
    assert layers.repeats == 4
    np.testing.assert_array_equal(region.array > 127, layers.covered)
    drive.undo()
    assert drive.cloth.region is None
    drive.tool("region").drag((100, 100), (120, 120), (140, 140))
    assert not TABLE.run("overlay.whole", drive.editor), "what is painted says where the cloth is"


def test_lattice_that_grows_is_shown_in_place_of_the_one_before(drive: OverlayDriver) -> None:
    later = Later()
    editor = Editor(drive.document, TOOLS, jobs=Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
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


def test_a_search_for_the_whole_cloth_is_shown_like_any_other_and_can_be_cancelled() -> None:
    later, live = Later(), InlineExecutor()
    drive = EditorDriver(Document.of(PHOTO).changed(mode="overlay"), jobs=Jobs(live=live, long=later, beside=live))
    assert TABLE.run("overlay.whole", drive.editor)
    overlay = drive.frame().editor.overlay
    ticket = overlay.under_way
    assert ticket is not None
    assert ticket.name == "Whole cloth"
    assert not TABLE.run("overlay.whole", drive.editor), "one at a time"
    keys = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
    frames = PatchFrames(20.0 * keys + 30, np.tile(20.0 * np.eye(2), (4, 1, 1)), np.ones(4))
    shape = PHOTO.height_px, PHOTO.width_px
    ticket.progress = Progress(0.5, preview=Stage("lattice", Lattice(keys, frames), shape=shape))
    drive.frame()
    assert len(lattice_shapes(drive.editor)) == 4
    overlay.cancel()
    drive.frame()
    assert not overlay.is_running
    assert not lattice_shapes(drive.editor)
    later.run()
    assert drive.frame().document.cloth.search is None
    assert TABLE.run("overlay.whole", drive.editor)
    again = overlay.under_way
    assert again is not None
    drive.editor.edit("Find pattern", drive.document.with_cloth(search=Search()))
    drive.frame()
    assert again.cancelled
    later.run()
    assert drive.frame().editor.overlay.is_final
    assert drive.labels == ("Find pattern",), "what is asked for meanwhile counts"
