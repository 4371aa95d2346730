import numpy as np
import pytest

from app.shapes import Bezier, Square
from app.tools.outline import ring_on_screen
from core.document import Outline
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
