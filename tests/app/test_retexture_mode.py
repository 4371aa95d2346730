from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.actions.table import ActionTable
from app.jobs import InlineExecutor, Jobs
from app.requests import ExportOptions
from app.shapes import Bezier, Polyline
from app.tools.all import TOOLS
from app.tools.marks import marks
from core.arrays import Points
from core.curves import Curve
from core.document import Document, pixels_from_places
from core.image import Image
from core.images import load
from core.progress import run
from core.project import load_project, save_project
from tests.app.driver import EditorDriver, Later

WIDTH, HEIGHT = 200, 150


def woven() -> Image:
    """Return a picture of fine texture: noise that runs along x."""
    random = np.random.default_rng(1)
    noise = random.random((HEIGHT, WIDTH + 8, 3))
    smooth = np.mean([noise[:, i : i + WIDTH] for i in range(8)], axis=0)
    return Image((255 * smooth).astype(np.uint8))


def start() -> Document:
    return Document.of(woven()).with_warp(cell_px=2.0).with_retexture(along_px=21, across_px=15, search_along_px=9)


def driver(jobs: Jobs | None = None, document: Document | None = None) -> EditorDriver:
    drive = EditorDriver(document or start(), jobs=jobs)
    drive.editor.choose_mode("retexture")
    return drive.tool("feature-curves").frame()


@pytest.fixture
def drive() -> EditorDriver:
    return driver()


def drawn(drive: EditorDriver) -> EditorDriver:
    """Draw a curve across the picture."""
    return drive.drag((50, 70), (60, 70)).drag((100, 70), (110, 70)).drag((150, 70), (160, 70)).key("enter")


def moved(drive: EditorDriver) -> EditorDriver:
    return drawn(drive).drag((100, 70), (100, 90))


def target(drive: EditorDriver) -> Points:
    return pixels_from_places(drive.document.size_px, drive.document.feature_curves[0].target)


def source(drive: EditorDriver) -> Points:
    return pixels_from_places(drive.document.size_px, drive.document.feature_curves[0].source)


def shown(drive: EditorDriver) -> Image:
    return drive.editor.regrowth.shown(drive.document, drive.editor.session.look).image


def test_the_pen_draws_a_feature_curve_and_no_inner_curve(drive: EditorDriver) -> None:
    drawn(drive)
    assert drive.labels == ("Draw curve",)
    assert np.allclose(source(drive)[::3], [(50, 70), (100, 70), (150, 70)])
    assert np.allclose(target(drive), source(drive))
    assert drive.document.curves == ()
    assert drive.document.mode == "retexture"
    assert shown(drive) is drive.document.image


def test_a_dragged_target_takes_the_picture_along_live(drive: EditorDriver) -> None:
    drawn(drive).press(100, 70).move(100, 80).move(100, 90)
    assert drive.in_("feature-curves.busy")
    assert drive.editor.regrowth.is_moving
    seen = drive.editor.regrowth.shown(drive.document, "deformed")
    assert np.array_equal(seen.warped, drive.editor.regrowth.flat.warped), "what is painted on the result would move"
    assert np.allclose(drive.screen_of(100, 70), (100, 90), atol=1)
    assert np.allclose(drive.screen_of(0, 149), (0, 149), atol=0.5)
    assert shown(drive) is drive.document.image
    assert not drive.editor.jobs.long_jobs
    drive.release(100, 90)
    assert not drive.editor.regrowth.is_moving


def test_the_final_deformation_takes_over_without_a_jump() -> None:
    later = Later()
    drive = driver(Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
    drawn(drive).press(100, 70).move(100, 100).move(120, 125)
    live = drive.editor.regrowth.shown(drive.document, "deformed").rest
    drive.release(120, 125)
    assert drive.editor.regrowth.stage is None
    later.run()
    final = drive.frame().editor.regrowth.shown(drive.document, "deformed").rest
    assert np.abs(live - final).max() < 3
    assert np.abs(live - drive.editor.regrowth.flat.warped).max() > 40


def test_letting_go_regrows_the_texture_and_export_gives_the_same(drive: EditorDriver, tmp_path: Path) -> None:
    from app.render.picture_file import exporting

    moved(drive)
    work = drive.editor.regrowth
    assert work.is_final
    assert work.stage is not None
    assert work.stage.found.patches > 5
    result = shown(drive)
    assert result is work.stage.image
    place = tmp_path / "out.png"
    run(exporting(drive.document, ExportOptions(place, drive.document.result_px)))
    assert np.array_equal(load(place).pixels, result.pixels)
    # Under the target lies what lay under the curve.
    assert np.abs(work.stage.found.place[90, 97:104, 1] - 70).max() < 2


def test_one_key_each_shows_original_deformed_and_retextured(drive: EditorDriver) -> None:
    moved(drive)
    table = ActionTable(TOOLS)
    pictures = []
    for key in "123":
        action = next(a for a in table.actions if a.chord == key)
        action.run(drive.editor)
        pictures.append(drive.editor.regrowth.shown(drive.document, drive.editor.session.look))
    assert pictures[0].image is drive.document.image
    assert pictures[0].rest is pictures[0].warped
    assert pictures[1].image is drive.document.image
    assert np.abs(pictures[1].rest - pictures[1].warped).max() > 15
    assert pictures[2].image is not drive.document.image


def test_the_deformed_picture_shows_the_source_at_the_target(drive: EditorDriver) -> None:
    moved(drive)
    assert np.allclose(drive.picture_at(100, 90), (100, 70), atol=1)


def test_a_curve_drawn_on_the_deformed_picture_begins_where_that_comes_from(drive: EditorDriver) -> None:
    moved(drive)
    drive.editor.show(selected_curve=None, selected_knots=frozenset())
    drive.click(100, 100).click(130, 120).key("enter")
    pair = drive.document.feature_curves[1]
    expected = drive.picture_at(100, 100)
    assert expected[1] < 95
    drive.editor.regrowth.update(drive.document, held=False, starts=False)
    assert np.allclose(pixels_from_places(drive.document.size_px, pair.source)[0], (100, 85.0), atol=6)


def test_undo_takes_the_result_back_and_redo_has_it_at_once() -> None:
    later = Later()
    drive = driver(Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
    moved(drive)
    assert not drive.editor.regrowth.is_final
    later.run()
    result = shown(drive.frame())
    assert result is not drive.document.image
    assert shown(drive.undo()) is drive.document.image
    drive.redo()
    assert shown(drive) is result
    assert not later.waiting


def test_a_new_drag_drops_the_job_under_way() -> None:
    later = Later()
    drive = driver(Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
    moved(drive)
    assert len(drive.editor.jobs.long_jobs) == 1
    first = drive.editor.jobs.long_jobs[0]
    drive.drag((100, 90), (100, 95))
    assert first.cancelled
    later.run()
    later.run()
    assert drive.frame().editor.regrowth.is_final


def test_a_cancelled_job_does_not_begin_again() -> None:
    later = Later()
    drive = driver(Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
    moved(drive)
    drive.editor.jobs.cancel_all()
    later.run()
    drive.frame().frame()
    assert not drive.editor.jobs.long_jobs
    assert not drive.editor.regrowth.is_running
    assert ActionTable(TOOLS).run("retexture.start", drive.editor)
    later.run()
    assert drive.frame().editor.regrowth.is_final


def test_switched_off_it_waits_to_be_asked(drive: EditorDriver) -> None:
    table = ActionTable(TOOLS)
    table.run("retexture.auto", drive.editor)
    moved(drive)
    assert drive.editor.regrowth.stage is None
    table.run("retexture.start", drive.editor)
    assert drive.frame().editor.regrowth.is_final


def test_a_curve_beside_the_picture_is_refused_in_words(drive: EditorDriver) -> None:
    drive.click(-90, 20).click(-60, 100).key("enter").drag((-60, 100), (-40, 60))
    assert "outside the picture" in (drive.editor.fault or "")
    drive.undo()
    assert drive.editor.fault is None


def test_passive_closed_and_copied_back(drive: EditorDriver) -> None:
    table = ActionTable(TOOLS)
    moved(drive)
    assert table.run("feature.passive", drive.editor)
    assert drive.document.feature_curves[0].passive
    assert drive.frame().editor.regrowth.stage is None
    table.run("feature.passive", drive.editor)
    table.run("feature.closed", drive.editor)
    assert drive.document.feature_curves[0].closed
    drive.undo().undo().undo()
    assert table.run("feature.put_back", drive.editor)
    assert np.array_equal(target(drive), source(drive))
    assert shown(drive.frame()) is drive.document.image
    assert drive.labels[-1] == "Copy source to target"


def test_the_box_turns_a_target(drive: EditorDriver) -> None:
    drawn(drive).key("a", ctrl=True)
    drive.drag((164, 84), (164, 104))
    assert drive.labels[-1] == "Scale curve"
    assert np.ptp(target(drive)[:, 1]) < 1e-9
    assert not np.allclose(target(drive), source(drive))


def test_the_brush_paints_the_matte_and_bounds_the_result(drive: EditorDriver) -> None:
    table = ActionTable(TOOLS)
    moved(drive)
    assert table.run("retexture.paint_matte", drive.editor)
    drive.drag((70, 85), (90, 85))
    assert drive.labels[-1] == "Paint matte"
    assert drive.document.mask.is_empty
    stage = drive.editor.regrowth.stage
    assert stage is not None
    assert drive.document.matte is not None
    assert not stage.found.label[drive.document.matte.array <= 127].any()
    assert table.run("retexture.clear_matte", drive.editor)
    assert drive.document.matte is None


def test_the_source_mask_is_painted_on_the_original(drive: EditorDriver) -> None:
    moved(drive)
    ActionTable(TOOLS).run("retexture.paint_source_mask", drive.editor)
    assert drive.editor.session.look == "original"
    drive.drag((20, 70), (180, 70))
    assert drive.document.source_mask is not None
    assert drive.document.source_mask.array[70, 100] == 255
    assert drive.document.matte is None


def test_source_target_and_ticks_are_drawn(drive: EditorDriver) -> None:
    moved(drive)
    shapes = drive.editor.tool.overlay(drive.editor)
    assert {s.role for s in shapes if isinstance(s, Bezier)} == {"source", "target"}
    assert sum(isinstance(s, Polyline) and s.role == "tick" for s in shapes) >= 2


def test_a_project_brings_curves_masks_and_mode_back(drive: EditorDriver, tmp_path: Path) -> None:
    moved(drive)
    ActionTable(TOOLS).run("retexture.paint_matte", drive.editor)
    drive.drag((70, 85), (90, 85))
    drive.editor.edit("Seed", drive.document.with_retexture(seed=7, reach=0.2))
    path = tmp_path / "project.weft"
    save_project(drive.document, path)
    again = EditorDriver(load_project(path))
    assert again.editor.session.mode == "retexture"
    assert again.document.retexture == drive.document.retexture
    assert np.array_equal(target(again), target(drive))
    assert again.document.matte is not None
    assert drive.document.matte is not None
    assert np.array_equal(again.document.matte.array, drive.document.matte.array)
    again.frame()
    drive.frame()
    assert np.array_equal(shown(again).pixels, shown(drive).pixels)


def test_the_warp_of_the_document_stands_apart(drive: EditorDriver) -> None:
    moved(drive)
    drive.editor.choose_mode("warp")
    drive.frame()
    assert np.allclose(drive.editor.answer.warped, drive.editor.answer.rest)
    drive.editor.edit("Bend", drive.document.with_warp(preset="arc", bend=40))
    assert drive.document.mode == "warp"
    assert not np.allclose(drive.frame().editor.answer.warped, drive.editor.answer.rest)
    drive.editor.choose_mode("retexture")
    assert shown(drive.frame()) is not drive.document.image


def test_overlays_show_what_the_result_is_made_of(drive: EditorDriver) -> None:
    table = ActionTable(TOOLS)
    moved(drive)
    stage = drive.editor.regrowth.stage
    assert stage is not None
    assert stage.seams.array[stage.found.seams].all()
    assert not stage.seams.array[:5].any()
    assert stage.compression.array.shape == (HEIGHT, WIDTH)
    for name, role in (("patches", "patch"), ("spines", "spine")):
        assert not any(isinstance(s, Polyline) and s.role == role for s in marks(drive.editor))
        assert table.run(f"view.overlay.{name}", drive.editor)
        lines = [s for s in marks(drive.editor) if isinstance(s, Polyline) and s.role == role]
        assert len(lines) >= len(stage.found.origins[0])
    drive.editor.show(look="original")
    assert not any(isinstance(s, Polyline) and s.role in ("patch", "spine") for s in marks(drive.editor))


def blob() -> EditorDriver:
    """Begin on a dark disc before a light ground."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    inside = np.hypot(x - 100, y - 75) < 45
    noise = np.random.default_rng(0).integers(0, 12, (HEIGHT, WIDTH))
    pixels = np.where(inside, 50, 190) + noise
    image = Image(np.repeat(pixels[..., None], 3, axis=2).astype(np.uint8))
    return driver(document=Document.of(image).with_warp(cell_px=4.0)).tool("trace")


def off_circle(points: Points) -> float:
    """Return how far a curve's points on the picture lie off the disc's edge at most."""
    curve = Curve(pixels_from_places((WIDTH, HEIGHT), points))
    return float(np.abs(np.hypot(*(curve.at(curve.parameters(step=2.0)) - (100, 75)).T) - 45).max())


def test_a_traced_curve_clings_to_the_edge() -> None:
    drive = blob()
    drive.click(55, 75).move(70, 45).move(98, 31)
    assert drive.editor.session.draft is not None
    assert drive.document is drive.start
    assert not drive.editor.regrowth.is_moving, "a path would be traced on a draft of the picture"
    drive.click(98, 31).click(144, 76).key("enter")
    assert drive.labels == ("Trace curve",)
    pair = drive.document.feature_curves[0]
    assert off_circle(pair.source) < 3
    assert np.array_equal(pair.source, pair.target)
    assert drive.editor.session.tool == "feature-curves"
    assert drive.editor.session.draft is None


def test_a_trace_closes_on_its_first_anchor_and_backspace_takes_one_back() -> None:
    drive = blob()
    drive.click(55, 75).click(100, 30).click(190, 10).key("backspace").click(145, 75).click(100, 120).click(56, 76)
    pair = drive.document.feature_curves[0]
    assert pair.closed
    assert off_circle(pair.source) < 3


def test_escape_leaves_no_trace_of_a_trace() -> None:
    drive = blob()
    drive.click(55, 75).click(100, 30).key("escape")
    assert drive.document is drive.start
    assert drive.editor.session.draft is None
    assert drive.in_("trace.idle")


def test_with_ctrl_a_trace_goes_straight() -> None:
    drive = blob()
    drive.click(55, 75).click(145, 75, ctrl=True).key("enter")
    points = pixels_from_places((WIDTH, HEIGHT), drive.document.feature_curves[0].source)
    assert np.allclose(points[:, 1], 75, atol=1e-6)


def test_a_rectangle_around_an_object_gives_its_outline() -> None:
    drive = blob()
    drive.drag((40, 20), (100, 60), (160, 130))
    assert drive.labels == ("Outline object",)
    pair = drive.document.feature_curves[0]
    assert pair.closed
    assert off_circle(pair.source) < 3


@pytest.mark.parametrize(
    ("first", "last", "fault"),
    [((-9, -9), (260, 200), "no ground"), ((10, 10), (14, 11), "too small"), ((2, 2), (20, 20), "nothing stands out")],
)
def test_a_rectangle_without_an_object_is_refused_in_words(
    first: tuple[float, float], last: tuple[float, float], fault: str
) -> None:
    drive = blob()
    drive.drag(first, last)
    drive.frame()
    assert fault in drive.editor.notices[-1].text
    assert drive.document is drive.start


def test_suggested_curves_are_taken_by_a_click() -> None:
    drive = blob().tool("feature-curves")
    assert ActionTable(TOOLS).run("feature.suggest", drive.editor)
    drive.frame()
    offered = drive.editor.session.suggestions
    assert offered
    assert off_circle(offered[0]) < 4
    assert drive.editor.session.tool == "trace"
    x, y = pixels_from_places((WIDTH, HEIGHT), offered[0])[0]
    drive.click(float(x), float(y))
    assert drive.labels == ("Take suggested curve",)
    assert len(drive.editor.session.suggestions) == len(offered) - 1


def test_what_is_painted_becomes_a_curve() -> None:
    drive = blob()
    table = ActionTable(TOOLS)
    table.run("retexture.paint_matte", drive.editor)
    drive.drag((60, 75), (140, 75))
    assert table.run("feature.outline", drive.editor)
    pair = drive.document.feature_curves[0]
    assert pair.closed
    assert drive.labels[-1] == "Outline mask"
    points = pixels_from_places((WIDTH, HEIGHT), pair.source)
    assert np.allclose(points.min(axis=0), (30, 45), atol=8)
    assert np.allclose(points.max(axis=0), (170, 105), atol=8)


def test_tracing_a_moved_picture_begins_by_showing_the_original(drive: EditorDriver) -> None:
    moved(drive).tool("trace").click(60, 40)
    assert drive.editor.session.look == "original"
    assert drive.in_("trace.idle")


def test_mask_actions_act_on_what_is_painted(drive: EditorDriver) -> None:
    table = ActionTable(TOOLS)
    table.run("retexture.paint_source_mask", drive.editor)
    assert table.run("mask.fill", drive.editor)
    assert drive.document.mask.is_empty
    assert drive.document.source_mask is not None
    assert drive.document.source_mask.array.min() == 255
    assert drive.labels == ("Fill source mask",)


def test_weft_render_gives_the_retextured_picture(drive: EditorDriver, tmp_path: Path) -> None:
    from app.cli import main

    moved(drive)
    save_project(drive.document, tmp_path / "project.weft")
    assert main(["render", str(tmp_path / "project.weft"), "-o", str(tmp_path / "out.png")]) == 0
    assert np.array_equal(load(tmp_path / "out.png").pixels, shown(drive).pixels)


def test_sources_are_edited_on_the_original_and_the_deformation_follows(drive: EditorDriver) -> None:
    table = ActionTable(TOOLS)
    moved(drive)
    before = target(drive).copy()
    assert table.run("handles.edit_source", drive.editor)
    assert drive.editor.session.look == "original"
    drive.press(100, 70).move(100, 60)
    seen = drive.editor.regrowth.shown(drive.document, drive.editor.session.look)
    assert seen.image is drive.document.image
    assert seen.rest is seen.warped
    assert np.allclose(drive.picture_at(100, 90), (100, 60), atol=1)
    assert drive.editor.session.look == "original"
    drive.release(100, 60)
    assert np.allclose(source(drive)[3], (100, 60))
    assert np.array_equal(target(drive), before)
    assert drive.editor.regrowth.is_final
    table.run("handles.edit_source", drive.editor)
    drive.press(100, 90).move(100, 95)
    assert np.allclose(drive.screen_of(100, 60), (100, 95), atol=1.5)
    drive.release(100, 95)


def test_a_closed_target_turned_over_is_refused_in_words() -> None:
    drive = blob().tool("feature-curves")
    drive.click(60, 50).click(140, 50).click(100, 110).click(61, 51).key("a", ctrl=True)
    pair = drive.document.feature_curves[0]
    turned = pair.target * [-1, 1] + [1, 0]
    drive.editor.edit("Turn over", drive.document.changed(feature_curves=(replace(pair, target=turned),)))
    assert "opposite directions" in (drive.frame().editor.fault or "")


def test_export_writes_the_result_of_the_mode(drive: EditorDriver, tmp_path: Path) -> None:
    from app import filing
    from app.render.picture_file import exporting
    from app.requests import ExportPicture

    moved(drive)
    drive.editor.edit("Size", drive.document.with_warp(aspect=(2.0, 1.0)))
    drive.editor.exporter = exporting
    filing.ask_export(drive.editor)
    request = drive.editor.requests.pop()
    assert isinstance(request, ExportPicture)
    assert request.options.size_px == (WIDTH, HEIGHT)
    request.then(replace(request.options, path=tmp_path / "out.png", bits=16))
    drive.frame()
    written = load(tmp_path / "out.png").pixels
    assert written.dtype == np.uint16
    assert np.abs(written / 257 - shown(drive).pixels).mean() < 0.5
