import numpy as np
import pytest

from app.editor.editor import Editor
from app.model.session import Brush
from app.model.shapes import Circle
from app.tools.all import TOOLS
from core.document.document import Document
from core.imaging.images import Image
from tests.app.driver import EditorDriver, document


@pytest.fixture
def drive() -> EditorDriver:
    drive = EditorDriver().tool("brush")
    drive.editor.show(brush=Brush(diameter_px=20.0, hardness=1.0))
    return drive


def test_a_stroke_paints_and_is_one_entry(drive: EditorDriver) -> None:
    drive.press(30, 40).move(60, 40).move(90, 40)
    assert drive.in_("brush.busy")
    assert drive.mask[40, 60] == 255
    drive.release()
    assert drive.in_("brush.idle")
    assert drive.labels == ("Paint mask",)
    assert drive.mask[40, 25] == 255
    assert drive.mask[40, 15] == 0
    assert drive.undo().document is drive.start


def test_escape_leaves_no_trace(drive: EditorDriver) -> None:
    drive.press(30, 40).move(90, 40).key("escape")
    assert drive.document is drive.start
    assert drive.labels == ()
    drive.move(100, 100).release()
    assert drive.document is drive.start


def test_x_swaps_paint_and_erase(drive: EditorDriver) -> None:
    drive.drag((30, 40), (90, 40)).key("x").drag((60, 20), (60, 60))
    assert drive.mask[40, 60] == 0
    assert drive.mask[40, 35] == 255
    assert drive.labels == ("Paint mask", "Erase mask")
    assert not drive.key("x").editor.session.brush.erase


def test_brackets_change_size_and_hardness(drive: EditorDriver) -> None:
    assert drive.key("]").editor.session.brush.diameter_px == 23
    assert drive.key("[").editor.session.brush.diameter_px == 20
    assert drive.key("[", shift=True).editor.session.brush.hardness == pytest.approx(0.9)
    assert drive.key("]", shift=True).key("]", shift=True).editor.session.brush.hardness == 1.0
    for _ in range(60):
        drive.key("[")
    assert drive.editor.session.brush.diameter_px == 1
    assert drive.key("]").editor.session.brush.diameter_px == 2


def test_alt_drag_sets_both_and_escape_puts_them_back(drive: EditorDriver) -> None:
    drive.press(50, 50, alt=True).move(65, 70, alt=True)
    assert drive.editor.session.brush == Brush(diameter_px=50.0, hardness=0.9)
    drive.release().press(50, 50, alt=True).move(0, 0, alt=True).key("escape")
    assert drive.editor.session.brush == Brush(diameter_px=50.0, hardness=0.9)
    assert drive.document is drive.start


def test_shift_draws_a_straight_line_from_the_last_dab(drive: EditorDriver) -> None:
    drive.click(30, 30).click(130, 110, shift=True)
    assert drive.mask[70, 80] == 255
    assert drive.mask[40, 100] == 0


def test_a_dab_is_painted_where_the_picture_is_seen(drive: EditorDriver) -> None:
    drive.editor.edit("Bend", drive.document.with_warp(preset="twist", bend=60))
    drive.frame()
    x, y = drive.screen_of(60, 50)
    assert np.hypot(x - 60, y - 50) > 5
    drive.click(x, y)
    assert drive.mask[50, 60] == 255


def test_the_map_follows_the_stroke(drive: EditorDriver) -> None:
    drive.editor.show(paints_unwarped=False)
    drive.editor.edit("Bend", drive.document.with_warp(preset="arc", bend=70))
    drive.frame()
    plain = drive.editor.map
    drive.press(*drive.screen_of(60, 60)).move(*drive.screen_of(120, 90))
    during = drive.editor.map
    assert during.features is not None
    assert len(during.features) == 1
    assert np.abs(during.warped - plain.warped).max() > 0.5
    drive.key("escape")
    assert np.allclose(drive.editor.map.warped, plain.warped)


def test_the_cursor_has_the_true_size(drive: EditorDriver) -> None:
    drive.wheel(100, 100, 3).move(50, 50)
    circle = drive.editor.tool.overlay(drive.editor)[0]
    assert isinstance(circle, Circle)
    assert circle.radius_px == pytest.approx(10.5 * drive.editor.session.view.zoom)


def test_a_finished_stroke_survives_a_change_of_tool(drive: EditorDriver) -> None:
    drive.press(30, 40).move(90, 40).tool("hand")
    assert drive.labels == ("Paint mask",)


def test_undo_in_a_stroke_takes_back_that_stroke_only(drive: EditorDriver) -> None:
    drive.drag((30, 40), (90, 40))
    once = drive.document
    drive.press(30, 80).move(90, 80).undo()
    assert drive.document is once
    assert drive.labels == ("Paint mask",)


def test_on_a_grid_of_one_pixel_cells() -> None:
    drive = EditorDriver(document(30, 20, cell_px=1.0)).tool("brush")
    drive.editor.show(brush=Brush(diameter_px=1.0, hardness=1.0))
    drive.click(7, 9)
    assert np.argwhere(drive.mask > 127).tolist() == [[9, 7]]


def test_the_brush_is_as_large_beside_every_picture() -> None:
    small = Editor(Document.of(Image(np.zeros((100, 100, 3), np.uint8))), TOOLS)
    large = Editor(Document.of(Image(np.zeros((1000, 1000, 3), np.uint8))), TOOLS)
    assert large.session.brush.diameter_px == 10 * small.session.brush.diameter_px
    small.show(brush=Brush(diameter_px=20.0, hardness=0.3))
    small.replace_document(large.document, project=None, source=None)
    assert small.session.brush == Brush(diameter_px=200.0, hardness=0.3)
