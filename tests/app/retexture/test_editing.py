"""What an artist edits in Retexture mode: feature curves and their switches, masks, and how they are drawn."""

from dataclasses import replace

import numpy as np
import pytest

from app.actions.table import ActionTable
from app.model.shapes import Bezier, Polyline
from app.tools.all import TOOLS
from core.document.document import UNSAID, pixels_from_places
from core.rasters.raster import Raster
from tests.app.driver import EditorDriver
from tests.app.retexture.driver import drawn, driver, moved, shown, source, target


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


def test_a_curve_drawn_on_the_deformed_picture_begins_where_that_comes_from(drive: EditorDriver) -> None:
    moved(drive)
    drive.editor.show(selected_curve=None, selected_knots=frozenset())
    drive.click(100, 100).click(130, 120).key("enter")
    pair = drive.document.feature_curves[1]
    expected = drive.picture_at(100, 100)
    assert expected[1] < 95
    drive.editor.regrowth.update(drive.document, held=False, starts=False)
    assert np.allclose(pixels_from_places(drive.document.size_px, pair.source)[0], (100, 85.0), atol=6)


def test_passive_closed_and_copied_back(drive: EditorDriver) -> None:
    table = ActionTable(TOOLS)
    moved(drive)
    assert table.run("feature.passive", drive.editor)
    assert drive.document.feature_curves[0].passive
    assert drive.frame().editor.regrowth.stage is None
    table.run("feature.passive", drive.editor)
    assert np.allclose(target(drive)[3], (100, 90)), "switched on and off again it goes where it went"
    table.run("feature.closed", drive.editor)
    assert drive.document.feature_curves[0].closed
    drive.undo().undo().undo()
    assert table.run("feature.put_back", drive.editor)
    assert np.array_equal(target(drive), source(drive))
    assert shown(drive.frame()) is drive.document.image
    assert drive.labels[-1] == "Copy source to target"


def test_the_box_moves_and_turns_a_target(drive: EditorDriver) -> None:
    drawn(drive).key("a", ctrl=True)
    drive.drag((80, 72), (80, 92))
    assert drive.labels[-1] == "Move curve"
    assert np.allclose(target(drive) - source(drive), (0, 20))
    drive.undo().drag((164 + 12, 84 + 12), (100, 180), shift=True)
    assert drive.labels[-1] == "Turn curve"
    assert np.allclose(source(drive)[::3], [(50, 70), (100, 70), (150, 70)])
    spread = np.ptp(target(drive), axis=0)
    assert spread.max() > 60
    assert np.hypot(*spread) == pytest.approx(np.hypot(*np.ptp(source(drive), axis=0)))


def test_the_box_scales_a_target(drive: EditorDriver) -> None:
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
    seen = drive.editor.regrowth.choose_picture(drive.document, drive.editor.session.look)
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


def test_the_source_mask_is_painted_on_no_other_picture_than_the_original(drive: EditorDriver) -> None:
    moved(drive)
    ActionTable(TOOLS).run("retexture.paint_source_mask", drive.editor)
    drive.editor.show(look="retextured")
    before = drive.document
    drive.drag((20, 70), (180, 70))
    assert drive.document is before
    assert drive.editor.session.look == "original"
    assert "original" in drive.editor.notices[-1].text
    drive.drag((20, 70), (180, 70))
    assert drive.labels[-1] == "Paint source mask"


def test_the_matte_lies_on_every_look_and_the_source_mask_on_the_original(drive: EditorDriver) -> None:
    from app.ui.canvas.scene import Motion, scene_of

    def tint() -> Raster | None:
        return scene_of(drive.editor, 1.0, Motion()).mask

    moved(drive)
    table = ActionTable(TOOLS)
    for name in ("matte", "source_mask"):
        table.run(f"retexture.paint_{name}", drive.editor)
        drive.drag((70, 85), (90, 85))
    for look in ("original", "deformed", "retextured"):
        drive.editor.show(look=look, painted="matte")
        assert tint() is drive.document.matte
        drive.editor.show(painted="source_mask")
        assert tint() is (drive.document.source_mask if look == "original" else None)
    table.run("feature.put_back", drive.editor)
    drive.editor.edit("Put back", drive.start.changed(source_mask=drive.document.source_mask))
    assert tint() is drive.document.source_mask


def test_one_brush_paints_more_and_less_regrown_and_the_tint_shows_it_at_once(drive: EditorDriver) -> None:
    from app.ui.canvas.scene import Motion, scene_of

    motion = Motion()

    def tint() -> Raster:
        raster = scene_of(drive.editor, 1.0, motion).mask
        assert raster is not None
        return raster

    moved(drive)
    drive.editor.choose_tool("brush")
    stage = drive.editor.regrowth.stage
    assert stage is not None
    assert "regrown" in drive.editor.tool.moment(drive.editor)
    assert np.array_equal(tint().array, stage.regrown.array), "B shows what is regrown before anything is painted"
    before, image = tint(), shown(drive)
    drive.press(30, 20).move(60, 20)
    assert drive.editor.regrowth.stage is stage, "while it is painted the result stays on the screen"
    assert tint().array[20, 45] == 255
    assert shown(drive) is image
    drive.release()
    far = (drive.document.size_px[0] - 1, drive.document.size_px[1] - 1)
    assert tint().array[far[1], far[0]] == before.array[far[1], far[0]]
    assert drive.labels[-1] == "Paint what is regrown"
    assert drive.editor.regrowth.stage is not stage
    assert (drive.editor.regrowth.stage.found.label[18:22, 34:56] > 0).all()
    drive.key("x").drag((90, 85), (110, 85))
    assert drive.document.regrow is not None
    assert not drive.editor.regrowth.stage.found.label[drive.document.regrow.array < 64].any()
    assert tint().array[85, 100] == 0
    ActionTable(TOOLS).run("mask.clear", drive.editor)
    assert (drive.document.regrow.array == UNSAID).all()
    drive.undo()
    ActionTable(TOOLS).run("retexture.clear_regrow", drive.editor)
    assert drive.document.regrow is None


def test_a_selection_says_what_is_regrown_and_leaves_the_rest_open(drive: EditorDriver) -> None:
    moved(drive)
    drive.tool("rectangle").drag((20, 15), (60, 30))
    assert drive.document.regrow is not None
    values = drive.document.regrow.array
    assert values[22, 40] == 255
    assert values[60, 100] == UNSAID
    drive.drag((20, 15), (40, 30), alt=True)
    assert drive.document.regrow.array[22, 30] == 0
    assert drive.document.regrow.array[22, 50] == 255


def test_deformed_and_original_are_wiped_over_the_result(drive: EditorDriver) -> None:
    from app.ui.canvas.scene import Motion, scene_of

    moved(drive)
    table, motion = ActionTable(TOOLS), Motion()
    assert table.run("look.beside.deformed", drive.editor)
    scene = scene_of(drive.editor, 1.0, motion)
    assert (scene.compare, drive.editor.session.look) == ("split", "retextured")
    assert scene.before is drive.document.image
    assert scene.before_rest is not None
    assert np.array_equal(scene.before_rest, drive.editor.regrowth.choose_picture(drive.document, "deformed").rest)
    assert scene.image is not drive.document.image
    assert table.run("look.deformed", drive.editor)
    assert drive.editor.session.compare == "split", "a look is chosen right of the divider"
    assert table.run("look.beside.original", drive.editor)
    assert scene_of(drive.editor, 1.0, motion).before_rest is None
    table.run("look.beside.original", drive.editor)
    assert scene_of(drive.editor, 1.0, motion).compare == "result"


def test_who_takes_the_tracer_sees_the_original(drive: EditorDriver) -> None:
    drawn(drive).tool("trace")
    assert drive.editor.session.look == "retextured", "nothing moves: all looks are the original"
    drive = moved(driver()).tool("trace")
    assert drive.editor.session.look == "original"
    drive.move(60, 40).press(60, 40).release().move(80, 40)
    assert drive.in_("trace.busy")
    assert "close" in drive.editor.tool.moment(drive.editor)
