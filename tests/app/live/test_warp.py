from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import app.live.warp
from app.files.warp_files import write_warp
from app.model.jobs import InlineExecutor, Jobs
from app.model.session import Brush
from core import tracing
from core.arrays import Ints
from core.document.document import CurvePair, Document, Outline, Pin
from core.document.map_solver import MapSolver, settle_map
from core.grid import Grid
from core.imaging.images import Image
from core.linalg.multifrontal import GridFactor
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.straight_lines import Lines, LineSolver
from core.mapping.result import Warped
from core.mapping.warper import Warper
from core.progress import run
from core.rasters.raster import Raster
from core.surfaces.shapes import make_shape
from tests.app.driver import EditorDriver, Later, document


def swirled() -> Document:
    """Return a document whose linear answer folds."""
    mask = np.zeros((150, 200), np.uint8)
    mask[40:110, 60:95] = mask[40:110, 105:140] = 255
    start = document(cell_px=4.0).changed(mask=Raster.from_array(mask))
    return start.with_warp(preset="twist", bend=80, keep="rigid")


def test_events_in_one_frame_cost_one_solve() -> None:
    drive = EditorDriver().tool("brush")
    tracing.start()
    for x in range(30, 90, 5):
        drive.editor.slide("Bend", drive.start.with_warp(preset="arc", bend=x))
    drive.frame()
    assert sum(event["name"] == "answer" for event in tracing.events()) == 1
    drive.frame().frame()
    assert sum(event["name"] == "answer" for event in tracing.events()) == 1


def test_at_rest_the_final_answer_comes_and_stays() -> None:
    drive = EditorDriver(swirled())
    linear = drive.editor.answer
    assert not linear.settled
    assert linear.folds > 0
    assert drive.editor.live.wait_s == pytest.approx(0.15)
    drive.rest()
    final = drive.editor.answer
    assert final.settled
    assert final.folds == 0
    assert drive.editor.live.wait_s is None
    assert drive.frame().editor.answer is final


@pytest.mark.parametrize(("inline_nodes", "threads"), [(60_000, 2), (0, 1)])
def test_a_mask_that_is_painted_dragged_rested_and_exported_is_factored_once_by_each_thread(
    inline_nodes: int, threads: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(app.live.warp, "INLINE_NODES", inline_nodes)
    factored: list[float] = []
    parts = GridFactor._parts

    def count(factor: GridFactor, boxes: Ints) -> Iterator[Ints]:
        if boxes.size:
            factored.append(boxes.size / len(factor._whole))
        return parts(factor, boxes)

    monkeypatch.setattr(GridFactor, "_parts", count)
    drive = EditorDriver(swirled().with_warp(keep="similarity")).rest()
    drive.editor.show(paints_unwarped=False)
    assert factored == [1.0] * threads
    factored.clear()
    drive.tool("brush").press(20, 30)
    for x in (25, 30, 35):
        drive.move(x, 30)
    drive.release().rest()
    assert all(share < 0.5 for share in factored)
    factored.clear()
    drive.tool("pins").press(30, 100)
    for x in (32, 34, 36):
        drive.move(x, 100)
    drive.release().rest()
    settled = drive.editor.live.settled(drive.document)
    assert settled is not None
    run(write_warp(drive.document, tmp_path / "map.exr", settled))
    assert not factored


def test_an_answer_that_took_long_is_not_taken_for_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    drive, frame = EditorDriver(swirled()), MapSolver.frame

    def slow(solver: MapSolver, asked: Document) -> Warped:
        drive.clock.now += 1.0
        return frame(solver, asked)

    monkeypatch.setattr(MapSolver, "frame", slow)
    drive.editor.slide("Bend", drive.start.with_warp(bend=60))
    drive.frame()
    assert drive.editor.answer.document is drive.document
    assert drive.editor.live.wait_s == pytest.approx(0.15)


def test_until_the_final_answer_is_there_the_first_without_folds_is_shown() -> None:
    drive = EditorDriver(swirled())
    assert drive.editor.answer.folds > 0
    drive.clock.now += app.live.warp.REST_S
    drive.editor.update()
    first = drive.editor.answer
    assert not first.settled
    assert first.folds == 0
    assert np.array_equal(first.mesh.warped, first.warped)
    final = drive.frame().editor.answer
    assert final.settled
    assert not np.array_equal(final.warped, first.warped)


def test_a_first_map_is_shown_whatever_was_done_meanwhile_that_maps_do_not_depend_on() -> None:
    later = Later()
    drive = EditorDriver(swirled(), jobs=Jobs(live=later, long=InlineExecutor()))
    later.run()
    assert drive.frame().editor.answer.folds > 0
    drive.clock.now += app.live.warp.REST_S
    drive.editor.update()
    drive.editor.slide("Bend", drive.document.with_warp(bend=60).with_warp(bend=80))
    drive.editor.live.update(drive.document)
    later.run()
    drive.editor.live.update(drive.document)
    assert drive.document is not drive.start
    assert drive.editor.answer.document is drive.document
    assert drive.editor.answer.folds == 0


def test_what_is_shown_at_rest_is_what_an_export_computes() -> None:
    drive = EditorDriver(swirled()).tool("brush")
    drive.editor.show(brush=Brush(12.0, 0.5))
    drive.drag((30, 30), (50, 50), (60, 30)).rest()
    result = run(settle_map(drive.document))
    assert (drive.editor.map.warped == result.warped).all()
    assert drive.editor.map.warped.tobytes() == result.warped.tobytes()


def test_the_final_answer_depends_on_nothing_but_the_document() -> None:
    drive = EditorDriver(swirled().with_warp(bend=40)).tool("pins")
    for step, place in enumerate([(30, 30), (170, 40), (100, 120), (40, 110)]):
        drive.drag(place, (place[0] + 5, place[1] + 3)).rest()
        if step == 2:
            drive.click(175, 43, alt=True).rest()
        final = drive.editor.answer
        assert final.settled
        assert final.warped.tobytes() == run(settle_map(drive.document)).warped.tobytes()
    drive.tool("brush").drag((90, 60), (110, 90)).rest()
    drive.tool("curves").click(60, 130).click(120, 140).key("enter").drag((60, 130), (60, 125)).rest()
    drive.tool("pins").click(150, 110).drag((150, 110), (160, 105)).rest()
    assert drive.editor.answer.settled
    assert drive.editor.answer.warped.tobytes() == run(settle_map(drive.document)).warped.tobytes()


def test_a_change_drops_the_final_answer_under_way() -> None:
    later = Later()
    drive = EditorDriver(swirled(), jobs=Jobs(live=later, long=InlineExecutor()))
    later.run()
    drive.frame().rest()
    assert later.waiting
    drive.editor.edit("Bend", drive.document.with_warp(bend=20))
    drive.frame()
    shown = drive.editor.answer
    later.run()
    assert drive.frame().editor.answer is shown
    drive.rest()
    later.run()
    assert drive.frame().editor.answer.settled


def test_large_grids_keep_the_last_answer_until_the_next_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(app.live.warp, "INLINE_NODES", 10)
    later = Later()
    drive = EditorDriver(jobs=Jobs(live=later, long=InlineExecutor()))
    later.run()
    first = drive.frame().editor.answer
    for bend in range(10, 60, 10):
        drive.editor.slide("Bend", drive.start.with_warp(preset="arc", bend=bend))
        assert drive.frame().editor.answer is first
    assert len(later.waiting) == 1
    later.run()
    second = drive.frame().editor.answer
    assert second.document.warp.bend == 10
    later.run()
    assert drive.frame().editor.answer.document.warp.bend == 50
    assert not later.waiting


def test_a_document_without_a_map_keeps_the_last_one_and_says_why() -> None:
    drive = EditorDriver()
    before = drive.editor.answer
    straight = np.linspace([0.3, 0.5], [0.7, 0.5], 4)
    curves = (CurvePair(straight, np.linspace([0.3, 0.5], [0.7, 0.5], 7)),)
    drive.editor.edit("Curve", drive.document.changed(curves=curves))
    drive.frame()
    assert drive.editor.answer is before
    assert "1 segments at the source, 2 at the target" in (drive.editor.live.fault or "")
    drive.undo()
    assert drive.editor.live.fault is None


def test_the_time_of_a_solve_is_that_of_handles_and_features(monkeypatch: pytest.MonkeyPatch) -> None:
    drive = EditorDriver().tool("pins")
    work = MapSolver.frame

    def slow(solver: MapSolver, document: Document) -> Warped:
        drive.clock.now += 0.012
        return work(solver, document)

    monkeypatch.setattr(MapSolver, "frame", slow)
    drive.press(60, 50).move(80, 50)
    assert drive.editor.answer.solve_ms == pytest.approx(12.0)


def test_an_outline_holds_the_edge_and_a_straight_one_changes_nothing() -> None:
    drive = EditorDriver(document().changed(outline=Outline.straight()))
    assert np.allclose(drive.editor.answer.warped, drive.editor.answer.rest)
    ring = Outline.straight().ring.copy()
    ring[0] += [-0.2, 0.1]
    ring[4:6] += [0.2, 0]
    moved = Outline(ring)
    drive.editor.edit("Outline", drive.document.changed(outline=moved))
    warped = drive.frame().editor.answer.warped
    assert np.allclose(warped[0, 0], [-0.2 * 200 - 0.5, 0.1 * 150 - 0.5])
    assert warped[:, -1, 0].max() > 200 + 0.7 * 0.2 * 200


@pytest.mark.parametrize(("width", "height"), [(1, 1), (1, 60), (60, 1), (3, 3)])
def test_the_smallest_pictures_have_a_map(width: int, height: int) -> None:
    drive = EditorDriver(Document.of(Image(np.zeros((height, width, 3), np.uint8))).with_warp(preset="arc", bend=30))
    drive.tool("brush").drag((0, 0), (5, 5)).rest()
    assert drive.editor.live.fault is None
    assert np.isfinite(drive.editor.answer.warped).all()


def test_a_picture_of_16384_pixels_a_side_is_warped_like_any_other() -> None:
    side = 16_384
    drive = EditorDriver(Document.of(Image(np.zeros((side, side, 1), np.uint8))).with_warp(cell_px=512.0))
    drive.editor.edit("Bend", drive.document.with_warp(preset="arch", bend=50.0))
    answer = drive.frame().rest().editor.answer
    assert answer.settled
    assert answer.folds == 0
    assert np.abs(answer.rest[-1, -1] - (side - 0.5)).max() < 1e-6
    drive.tool("brush").drag((100, 100), (140, 120))
    assert not drive.document.mask.is_empty
    assert drive.undo().undo().document is drive.start


@pytest.mark.parametrize(("inline", "most"), [(10, 1), (60_000, 2)])
def test_what_one_answer_has_built_the_next_one_finds(inline: int, most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(app.live.warp, "INLINE_NODES", inline)
    made: list[Warper] = []
    begin = Warper.__init__

    def counted(warper: Warper, grid: Grid, **more: Any) -> None:
        made.append(warper)
        begin(warper, grid, **more)

    monkeypatch.setattr(Warper, "__init__", counted)
    drive = EditorDriver(swirled())
    drive.rest()
    for bend in (20, 30):
        drive.editor.slide("Bend", drive.document.with_warp(bend=bend))
        drive.frame()
        assert drive.editor.answer.document.warp.bend == bend
    drive.editor.finish()
    drive.rest()
    assert drive.editor.answer.settled
    assert np.array_equal(drive.editor.answer.warped, run(settle_map(drive.document)).warped)
    assert len(made) == most + 1  # one of them by `settle_map`


def test_straight_lines_are_prepared_beside_the_frames_also_after_a_stroke(monkeypatch: pytest.MonkeyPatch) -> None:
    later, beside = Later(), False
    prepared: list[bool] = []
    prepare = LineSolver.__init__

    def note(solver: LineSolver, mapping: FeatureMapping, lines: Lines, weight: float) -> None:
        prepared.append(beside)
        prepare(solver, mapping, lines, weight)

    def run_beside() -> None:
        nonlocal beside
        beside = True
        later.run()
        beside = False
        drive.frame()

    def rest() -> None:
        drive.clock.now += app.live.warp.REST_S
        drive.frame()
        while not drive.editor.live.is_settled:
            run_beside()

    monkeypatch.setattr(LineSolver, "__init__", note)
    pixels = np.full((150, 200, 3), 200, np.uint8)
    pixels[70:] = 40
    mask = np.zeros((150, 200), np.uint8)
    mask[50:110, 60:95] = 255
    start = Document.of(Image(pixels)).changed(mask=Raster.from_array(mask)).with_warp(cell_px=4.0, straight=True)
    drive = EditorDriver(start.with_warp(aspect=(0.7, 1.0)), jobs=Jobs(live=later, long=InlineExecutor()))
    run_beside()
    rest()
    drive.tool("brush")
    drive.editor.show(brush=Brush(12.0, 0.5))
    for step in range(3):
        drive.drag((20 + 40 * step, 30), (30 + 40 * step, 40), (25 + 40 * step, 100))
        assert drive.editor.answer.document.mask is drive.document.mask
        rest()
        for width in (0.71, 0.72):
            drive.editor.slide("Resize", drive.document.with_warp(aspect=(width, 1.0)))
            drive.frame()
            assert drive.editor.answer.document is drive.document
        drive.editor.finish()
        rest()
    assert len(prepared) >= 4
    assert all(prepared)


@pytest.mark.parametrize("inline", [100, 60_000])
def test_rough_answers_that_glide_without_end_are_followed_by_the_final_one(
    inline: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(app.live.warp, "INLINE_NODES", inline)
    later = Later()
    pixels = np.full((150, 200, 3), 200, np.uint8)
    pixels[70:] = 40
    mask = np.zeros((150, 200), np.uint8)
    mask[50:110, 90:135] = 255
    pins = (Pin((0.13, 0.55), (0.13, 0.55)), Pin((0.15, 0.57), (0.11, 0.45)))
    start = Document.of(Image(pixels)).changed(pins=pins).with_warp(cell_px=4.0)
    drive = EditorDriver(start, jobs=Jobs(live=later, long=InlineExecutor()))

    def rest() -> None:
        for _ in range(12):
            drive.clock.now += app.live.warp.REST_S
            drive.frame()
            later.run()
            drive.frame()

    rest()
    changed = drive.document.changed(mask=Raster.from_array(mask)).with_warp(aspect=(1.0, 0.56), straight=True)
    drive.editor.slide("Resize", changed)
    rest()
    assert drive.editor.live.is_settled
    assert drive.editor.answer.folds == 0


def test_another_surface_is_answered_beside_the_window() -> None:
    later = Later()
    drive = EditorDriver(swirled(), jobs=Jobs(live=later, long=InlineExecutor()))
    later.run()
    flat = drive.frame().editor.answer
    surface = make_shape("cylinder", None)
    drive.editor.edit("Cylinder", drive.document.changed(surface=surface))
    drive.frame()
    assert drive.editor.answer is flat
    later.run()
    laid = drive.frame().editor.answer
    assert laid.document is drive.document
    drive.editor.slide("Bend", drive.document.with_warp(bend=60))
    assert drive.frame().editor.answer.document is drive.document


def test_what_is_painted_beside_a_surface_is_answered_beside_the_window() -> None:
    later = Later()
    drive = EditorDriver(swirled(), jobs=Jobs(live=later, long=InlineExecutor()))
    surface = make_shape("cylinder", None)
    drive.editor.edit("Cylinder", drive.document.changed(surface=surface))
    later.run()
    drive.frame().tool("brush")
    before = drive.frame().editor.map
    drive.press(20, 30).move(40, 30)
    assert drive.editor.unwarped.is_shown
    assert drive.editor.map is before
    for _ in range(2):
        later.run()
        drive.frame()
    assert drive.editor.map.document is drive.document
