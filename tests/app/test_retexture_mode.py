"""Retexture mode as an artist meets it: curves, the live deformation, the job and what is shown."""

from dataclasses import replace

import numpy as np
import pytest

from app.actions.table import ActionTable
from app.jobs import InlineExecutor, Jobs
from app.shapes import Bezier, Polyline
from app.tools.all import TOOLS
from app.tools.marks import marks
from core.arrays import Points
from core.document import CurvePair, pixels_from_places, places_from_pixels
from tests.app.driver import EditorDriver, Later
from tests.app.retexture_driver import HEIGHT, WIDTH, drawn, driver, moved, shown, source, start, target


@pytest.fixture
def drive() -> EditorDriver:
    return driver()


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


def test_who_drags_a_target_on_the_original_sees_the_deformation(drive: EditorDriver) -> None:
    drawn(drive)
    drive.editor.show(look="original")
    drive.press(100, 70).move(100, 80).move(100, 90)
    assert drive.editor.session.look == "retextured"
    assert shown(drive) is drive.document.image
    drive.release(100, 90)


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


def test_mask_actions_act_on_what_is_painted(drive: EditorDriver) -> None:
    table = ActionTable(TOOLS)
    table.run("retexture.paint_source_mask", drive.editor)
    assert table.run("mask.fill", drive.editor)
    assert drive.document.mask.is_empty
    assert drive.document.source_mask is not None
    assert drive.document.source_mask.array.min() == 255
    assert drive.labels == ("Fill source mask",)


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


def test_the_grids_of_patches_follow_passive_curves() -> None:
    def places(first: tuple[float, float], last: tuple[float, float]) -> Points:
        return places_from_pixels((WIDTH, HEIGHT), np.linspace(first, last, 4))

    straight, slanted = places((20, 60), (180, 60)), places((60, 90), (140, 120))
    pairs = (CurvePair(straight, straight + [0, 0.06]), CurvePair(slanted, slanted, passive=True))
    drive = driver(document=start().with_retexture(reach=0.5).changed(feature_curves=pairs))
    stage = drive.frame().editor.regrowth.stage
    assert stage is not None
    spines = stage.grids[:, stage.grids.shape[1] // 2]
    middles = spines[:, spines.shape[1] // 2]
    beside = np.hypot(*(middles - (100, 109)).T).argsort()[:3]
    along = spines[beside, -1] - spines[beside, 0]
    assert np.abs(np.degrees(np.arctan(along[:, 1] / along[:, 0])) - 20.5).max() < 8


def test_a_curve_with_needless_points_is_simplified_in_one_step(drive: EditorDriver) -> None:
    table = ActionTable(TOOLS)
    drawn(drive)
    for x in (70, 80, 120, 130):
        drive.click(x, 70)
    before = drive.document
    assert len(before.feature_curves[0].source) == 13
    assert table.run("feature.simplify", drive.editor)
    assert len(drive.document.feature_curves[0].source) == 4
    assert np.abs(source(drive)[:, 1] - 70).max() < 1
    assert drive.labels[-1] == "Simplify curve"
    assert table.run("feature.simplify", drive.editor)
    assert "No point can go" in drive.editor.notices[-1].text
    assert drive.undo().document is before


def test_a_matte_that_was_painted_and_erased_bounds_nothing(drive: EditorDriver) -> None:
    table = ActionTable(TOOLS)
    moved(drive)
    free = shown(drive).pixels
    assert table.run("retexture.paint_matte", drive.editor)
    drive.drag((70, 85), (90, 85))
    assert not np.array_equal(shown(drive).pixels, free)
    drive.editor.show(brush=replace(drive.editor.session.brush, erase=True, diameter_px=200))
    drive.drag((70, 85), (90, 85))
    assert drive.editor.fault is None
    assert np.array_equal(shown(drive).pixels, free)
