import numpy as np
import pytest

from app.actions.table import ActionTable
from app.model.shapes import Bezier, Square
from app.tools.all import TOOLS
from app.tools.outline import box_of, find_selected, ring_on_screen
from app.tools.points.box import MARGIN_PX
from core.document.document import Outline
from tests.app.driver import EditorDriver

CORNERS = [(-0.5, -0.5), (199.5, -0.5), (199.5, 149.5), (-0.5, 149.5)]


@pytest.fixture
def drive() -> EditorDriver:
    drive = EditorDriver().tool("outline")
    drive.editor.show(view=drive.editor.session.view.__class__(pan=(100.0, 100.0), size=(800.0, 600.0)))
    return drive


def at(x: float, y: float) -> tuple[float, float]:
    """Return the screen position of a canvas position."""
    return x + 100, y + 100


def ring(drive: EditorDriver) -> list[tuple[float, float]]:
    return [(round(float(x), 5), round(float(y), 5)) for x, y in ring_on_screen(drive.editor)[:-1] - 100]


def test_an_untouched_picture_has_a_straight_outline(drive: EditorDriver) -> None:
    assert ring(drive)[::3] == CORNERS
    assert np.allclose(ring(drive)[1], (-0.5 + 200 / 3, -0.5), atol=1e-4)
    assert drive.document.outline is None


def test_a_corner_takes_its_handles_and_the_picture_along(drive: EditorDriver) -> None:
    drive.drag(at(-0.5, -0.5), at(-30, -20), at(-40.5, -30.5))
    assert ring(drive)[0] == (-40.5, -30.5)
    assert ring(drive)[3] == CORNERS[1]
    assert drive.labels == ("Move corner",)
    assert np.allclose(drive.editor.answer.warped[0, 0], (-40.5, -30.5))
    assert drive.undo().document is drive.start


def test_a_handle_bends_its_side_only(drive: EditorDriver) -> None:
    x, y = ring(drive)[1]
    drive.drag(at(x, y), at(x, y - 60))
    warped = drive.editor.answer.warped
    assert warped[0, :, 1].min() < -20
    assert np.allclose(warped[-1], drive.editor.answer.rest[-1])
    assert np.allclose(warped[:, 0], drive.editor.answer.rest[:, 0])


def test_a_side_is_bent_where_it_is_gripped(drive: EditorDriver) -> None:
    drive.drag(at(100, 149.5), at(100, 180))
    curve = np.array(ring(drive))
    assert drive.labels == ("Bend side",)
    assert drive.editor.answer.warped[-1, :, 1].max() == pytest.approx(180, abs=1)
    assert np.allclose(curve[::3], CORNERS)


def test_smooth_corners_link_unless_alt_is_held(drive: EditorDriver) -> None:
    smooth = Outline.straight().ring.copy()
    smooth[[11, 1]] = smooth[0] + [[-0.1, 0.1], [0.1, -0.1]]
    drive.editor.edit("Smooth", drive.document.changed(outline=Outline(smooth)))
    x, y = ring(drive)[1]
    drive.drag(at(x, y), at(x + 15, y + 15))
    here = np.array(ring(drive))
    a, b = here[1] - here[0], here[11] - here[0]
    assert a[0] * b[1] - a[1] * b[0] == pytest.approx(0, abs=1e-3)
    assert a @ b < 0
    before = here[11]
    drive.press(*at(*here[1])).move(*at(here[1][0] + 20, here[1][1] + 30), alt=True).release()
    assert np.allclose(ring(drive)[11], before)


def test_the_outline_starts_where_the_preset_has_the_edge(drive: EditorDriver) -> None:
    drive.editor.edit("Bend", drive.document.with_warp(preset="arch", bend=40))
    drive.frame()
    before = drive.editor.answer.warped
    assert np.allclose(ring_on_screen(drive.editor)[0] - 100, before[0, 0], atol=1e-6)
    x, y = ring(drive)[6]
    drive.drag(at(x, y), at(x + 12, y + 9))
    after = drive.editor.answer.warped
    assert np.allclose(after[-1, -1], (x + 12, y + 9), atol=1e-6)
    assert np.abs(after[0] - before[0]).max() < 3


def test_double_click_straightens(drive: EditorDriver) -> None:
    drive.drag(at(100, 149.5), at(100, 180)).double_click(*at(100, 180))
    assert np.allclose(drive.editor.answer.warped, drive.editor.answer.rest)
    assert drive.labels == ("Bend side", "Straighten outline")


def test_arrows_nudge_the_gripped_corner(drive: EditorDriver) -> None:
    drive.click(*at(-0.5, -0.5)).key("left").key("up", shift=True)
    assert ring(drive)[0] == (-1.5, -10.5)
    assert any(isinstance(s, Square) and s.role == "knot-selected" for s in drive.editor.tool.overlay(drive.editor))
    drive.undo()
    assert drive.document is drive.start


def test_a_press_elsewhere_does_nothing(drive: EditorDriver) -> None:
    drive.drag(at(100, 70), at(120, 90))
    assert drive.document is drive.start


def test_escape_leaves_no_trace(drive: EditorDriver) -> None:
    drive.press(*at(-0.5, -0.5)).move(*at(-50, -50)).key("escape")
    assert drive.document is drive.start


def test_the_overlay_has_one_curve_and_four_corners(drive: EditorDriver) -> None:
    shapes = drive.editor.tool.overlay(drive.editor)
    assert len([s for s in shapes if isinstance(s, Bezier)]) == 1
    assert len([s for s in shapes if isinstance(s, Square)]) == 4


def test_all_corners_in_a_box_move_the_outline_as_one(drive: EditorDriver) -> None:
    drive.drag(at(100, 149.5), at(100, 180))
    before = np.array(ring(drive))
    take_all(drive)
    drive.drag(at(60, 60), at(70, 65), at(80, 71))
    assert np.allclose(ring(drive), before + (20, 11), atol=1e-4)
    assert drive.labels == ("Bend side", "Move outline")
    drive.undo().undo()
    assert drive.document is drive.start


def test_the_box_holds_the_bent_sides_too(drive: EditorDriver) -> None:
    drive.drag(at(100, 149.5), at(100, 220))
    take_all(drive)
    box = box_of(drive.editor)
    assert box is not None
    assert box.high[1] - 100 == pytest.approx(220 + MARGIN_PX, abs=1)


def test_the_box_scales_about_its_opposite_corner(drive: EditorDriver) -> None:
    take_all(drive)
    box = box_of(drive.editor)
    assert box is not None
    left, (right, bottom) = box.low[0], box.high
    drive.drag((right, bottom), (right + 9, bottom), (right + (right - left), bottom))
    scaled = np.array(ring(drive))
    assert drive.labels == ("Scale outline",)
    assert scaled[3, 0] - scaled[0, 0] == pytest.approx(400, abs=1e-3)
    assert scaled[9, 1] - scaled[0, 1] == pytest.approx(150, abs=1e-3)


def test_beside_a_corner_the_box_turns_the_outline(drive: EditorDriver) -> None:
    take_all(drive)
    box = box_of(drive.editor)
    assert box is not None
    x, y = box.high + 14
    middle = (box.low + box.high) / 2
    away = np.array([x, y]) - middle
    drive.press(x, y).move(*(middle + (-away[1], away[0]))).release()
    corners = np.array(ring(drive))[::3]
    assert drive.labels == ("Turn outline",)
    assert np.allclose(corners.mean(axis=0), np.mean(CORNERS, axis=0), atol=1e-3)
    assert np.allclose(corners[1] - corners[0], (0, 200), atol=1e-3)


def test_corners_are_selected_by_shift_and_by_a_rectangle(drive: EditorDriver) -> None:
    drive.click(*at(-0.5, -0.5)).click(*at(199.5, -0.5), shift=True)
    assert find_selected(drive.editor) == {0, 1}
    drive.click(*at(-0.5, -0.5), shift=True)
    assert find_selected(drive.editor) == {1}
    drive.drag(at(-40, 120), at(0, 170), at(240, 190))
    assert find_selected(drive.editor) == {2, 3}
    assert drive.editor.session.band is None
    drive.drag(at(-0.5, 149.5), at(-0.5, 160), at(-0.5, 170))
    assert [y for _, y in ring(drive)[::3]] == pytest.approx([-0.5, -0.5, 170, 170], abs=1e-3)
    assert drive.labels == ("Move corners",)
    drive.key("escape")
    assert not find_selected(drive.editor)


def take_all(drive: EditorDriver) -> None:
    """Put a box around the whole outline."""
    assert ActionTable(TOOLS).run("handles.select_all", drive.editor)
    assert find_selected(drive.editor) == {0, 1, 2, 3}


def test_corners_of_a_perspective_stay_those_of_a_perspective(drive: EditorDriver) -> None:
    drive.editor.edit("Preset", drive.document.with_warp(preset="perspective", bend=40.0, vertical_axis=True))
    before = np.array(ring(drive))[::3]
    x, y = before[0]
    drive.drag(at(x, y), at(x + 20, y + 30))
    after = np.array(ring(drive))[::3]
    assert np.allclose(after[0], (x + 20, y + 30), atol=1e-3)
    assert np.allclose(after[1:], before[1:], atol=1e-3)
    assert drive.document.outline is None
    assert drive.document.warp.bend == 0
    assert drive.labels[-1] == "Move corner"
    middle = drive.editor.answer.warped[:, drive.editor.answer.warped.shape[1] // 2]
    along, away = middle[-1] - middle[0], middle - middle[0]
    off_line = (away[:, 0] * along[1] - away[:, 1] * along[0]) / np.hypot(*along)
    assert np.abs(off_line).max() < 1e-6
    drive.key("down")
    assert np.allclose(np.array(ring(drive))[0], (x + 20, y + 31), atol=1e-3)
    drive.undo().undo()
    assert drive.document.warp.bend == 40


def test_a_perspective_keeps_its_last_convex_corners(drive: EditorDriver) -> None:
    drive.editor.edit("Preset", drive.document.with_warp(preset="perspective"))
    drive.drag(at(-0.5, -0.5), at(60, 40), at(150, 120))
    assert np.allclose(ring(drive)[0], (60, 40), atol=1e-3)
    assert drive.document.outline is None
    before = drive.document
    drive.double_click(*at(60, 40))
    assert drive.document is before


def test_a_bent_side_of_a_perspective_is_an_outline(drive: EditorDriver) -> None:
    drive.editor.edit("Preset", drive.document.with_warp(preset="perspective", bend=40.0))
    drive.drag(at(100, 149.5), at(100, 180))
    assert drive.document.outline is not None
    assert drive.document.warp.bend == 40
