"""The job of Retexture mode and what is shown of it: the live deformation, its stages, looks and overlays."""

import numpy as np
import pytest

from app.actions.table import ActionTable
from app.model.jobs import InlineExecutor, Jobs
from app.model.shapes import Bezier, Polyline
from app.tools.all import TOOLS
from app.tools.marks import marks
from core.arrays import Points
from core.curves.bezier import Curve
from core.document.document import CurvePair, places_from_pixels
from tests.app.driver import EditorDriver, Later
from tests.app.retexture.driver import HEIGHT, WIDTH, drawn, driver, moved, shown, start


@pytest.fixture
def drive() -> EditorDriver:
    return driver()


def test_a_dragged_target_takes_the_picture_along_live(drive: EditorDriver) -> None:
    drawn(drive).press(100, 70).move(100, 80).move(100, 90)
    assert drive.in_("feature-curves.busy")
    assert drive.editor.regrowth.is_moving
    seen = drive.editor.regrowth.choose_picture(drive.document, "deformed")
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
    live = drive.editor.regrowth.choose_picture(drive.document, "deformed").rest
    drive.release(120, 125)
    assert drive.editor.regrowth.stage is None
    later.run()
    final = drive.frame().editor.regrowth.choose_picture(drive.document, "deformed").rest
    assert np.abs(live - final).max() < 3
    assert np.abs(live - drive.editor.regrowth.flat.warped).max() > 40


def test_one_key_each_shows_original_deformed_and_retextured(drive: EditorDriver) -> None:
    moved(drive)
    table = ActionTable(TOOLS)
    pictures = []
    for key in "123":
        action = next(a for a in table.actions if a.chord == key)
        action.run(drive.editor)
        pictures.append(drive.editor.regrowth.choose_picture(drive.document, drive.editor.session.look))
    assert pictures[0].image is drive.document.image
    assert pictures[0].rest is pictures[0].warped
    assert pictures[1].image is drive.document.image
    assert np.abs(pictures[1].rest - pictures[1].warped).max() > 15
    assert pictures[2].image is not drive.document.image


def test_the_deformed_picture_shows_the_source_at_the_target(drive: EditorDriver) -> None:
    moved(drive)
    assert np.allclose(drive.picture_at(100, 90), (100, 70), atol=1)


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
    visible = np.unique(stage.found.label[stage.found.label > 0])
    assert len(stage.grids) == len(visible)
    assert len(visible) > len(stage.found.origins[0]), "the first batch would do"
    for name, role in (("patches", "patch"), ("spines", "spine")):
        assert not any(isinstance(s, Polyline) and s.role == role for s in marks(drive.editor))
        assert table.run(f"view.overlay.{name}", drive.editor)
        lines = [s for s in marks(drive.editor) if isinstance(s, Polyline) and s.role == role]
        assert len(lines) >= len(visible)
    drive.editor.show(look="original")
    assert not any(isinstance(s, Polyline) and s.role in ("patch", "spine") for s in marks(drive.editor))


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


def test_where_a_passive_curve_has_gone_is_drawn_on_the_result_only() -> None:
    straight = places_from_pixels((WIDTH, HEIGHT), np.linspace((20, 60), (180, 60), 4))
    follower = places_from_pixels((WIDTH, HEIGHT), np.linspace((60, 70), (140, 70), 4))
    pairs = (CurvePair(straight, straight + [0, 0.1]), CurvePair(follower, follower, passive=True))
    drive = driver(document=start().changed(feature_curves=pairs)).frame()

    def followers() -> list[Bezier]:
        return [s for s in marks(drive.editor) if isinstance(s, Bezier) and s.role == "passive" and s.dashed]

    (line,) = followers()
    shown_at = drive.screen_of(100, 70)
    assert shown_at[1] > 75
    assert np.abs(Curve(line.points).nearest(np.array([shown_at]))[1]).max() < 1.5
    drive.editor.show(look="original")
    assert followers() == []


def ends_of_drag(drive: EditorDriver) -> None:
    """Check that nothing of a job is left over."""
    assert not drive.editor.jobs.long_jobs
    assert not drive.editor.regrowth.is_running


def test_undo_during_the_job_drops_it_and_redo_begins_it_anew() -> None:
    later = Later()
    drive = driver(Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
    moved(drive)
    first = drive.editor.jobs.long_jobs[0]
    drive.undo()
    assert first.cancelled
    assert shown(drive) is drive.document.image
    later.run()
    drive.frame()
    ends_of_drag(drive)
    drive.redo()
    assert drive.editor.regrowth.is_running
    later.run()
    assert drive.frame().editor.regrowth.is_final
    assert shown(drive) is not drive.document.image


def test_a_job_goes_on_in_another_mode_and_its_result_is_there_afterwards() -> None:
    later = Later()
    drive = driver(Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
    moved(drive)
    drive.editor.choose_mode("warp")
    assert not drive.frame().editor.jobs.long_jobs[0].cancelled
    later.run()
    drive.frame()
    drive.editor.choose_mode("retexture")
    assert drive.frame().editor.regrowth.is_final
    ends_of_drag(drive)


@pytest.mark.parametrize("way", ["key", "action", "passive"])
def test_without_a_curve_that_moves_the_picture_is_as_it_was(way: str) -> None:
    later = Later()
    drive = driver(Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
    moved(drive)
    if way == "key":
        drive.editor.show(selected_knots=frozenset())
        drive.key("delete")
    else:
        ActionTable(TOOLS).run("feature.remove_all" if way == "action" else "feature.passive", drive.editor)
    later.run()
    drive.frame()
    ends_of_drag(drive)
    assert drive.editor.fault is None
    assert drive.editor.regrowth.stage is None
    assert shown(drive) is drive.document.image
    assert not ActionTable(TOOLS).run("retexture.start", drive.editor)
    drive.undo()
    later.run()
    assert drive.frame().editor.regrowth.is_final
