"""Feature curves that snap to their edge, and long edges that Retexture keeps until they are clicked away."""

import numpy as np
import pytest

from app.actions.table import ActionTable
from app.model.shapes import Polyline
from app.tools.all import TOOLS
from app.tools.marks import marks
from core.arrays import Bytes
from core.document.document import CurvePair, Document, pixels_from_places, places_from_pixels
from core.imaging.image import Image
from tests.app.driver import EditorDriver

WIDTH, HEIGHT = 320, 220
TABLE = ActionTable(TOOLS)


def fence() -> Bytes:
    """Return grass below light ground, a bent border between them, and palings behind it."""
    pixels = np.full((HEIGHT, WIDTH, 3), 200, np.uint8)
    x = np.arange(WIDTH)
    border = 160 - 30 * np.sin(np.pi * x / WIDTH)
    for left in range(30, WIDTH - 30, 40):
        pixels[40:, left : left + 14] = 255
    pixels[np.arange(HEIGHT)[:, None] > border] = (40, 80, 30)
    return pixels


@pytest.fixture
def drive() -> EditorDriver:
    drive = EditorDriver(Document.of(Image(fence())))
    drive.editor.choose_mode("retexture")
    return drive.tool("feature-curves")


def moved(drive: EditorDriver) -> EditorDriver:
    """Lay a curve on the border and move it up."""
    x = np.linspace(30, WIDTH - 30, 7)
    source = np.stack([x, 160 - 30 * np.sin(np.pi * x / WIDTH)], axis=-1)
    size = WIDTH, HEIGHT
    pair = CurvePair(places_from_pixels(size, source), places_from_pixels(size, source - [0.0, 15.0]))
    drive.editor.edit("Draw curve", drive.document.changed(feature_curves=(pair,)))
    drive.frame().rest()
    return drive


def edges(drive: EditorDriver) -> list[Polyline]:
    return [shape for shape in marks(drive.editor) if isinstance(shape, Polyline) and shape.role == "edge"]


def test_a_curve_drawn_beside_its_edge_comes_onto_it_and_undo_takes_that_back_alone(drive: EditorDriver) -> None:
    beside = [(x, 160 - 30 * np.sin(np.pi * x / WIDTH) + 6) for x in (60, 140, 220, 280)]
    for x, y in beside:
        drive.click(x, y)
    drive.key("enter")
    assert drive.labels[-2:] == ("Draw curve", "Snap curve to edge")
    knots = pixels_from_places((WIDTH, HEIGHT), drive.document.feature_curves[0].source)[::3]
    assert np.abs(knots[:, 1] - 160 + 30 * np.sin(np.pi * knots[:, 0] / WIDTH)).max() < 3
    drive.undo()
    assert drive.labels[-2:] == ("Draw curve", "Snap curve to edge")
    knots = pixels_from_places((WIDTH, HEIGHT), drive.document.feature_curves[0].source)[::3]
    assert np.allclose(knots, beside, atol=0.01)


def test_with_snapping_off_it_stays(drive: EditorDriver) -> None:
    TABLE.run("feature.snaps", drive.editor)
    for x in (60, 140, 220, 280):
        drive.click(x, 160 - 30 * np.sin(np.pi * x / WIDTH) + 6)
    drive.key("enter")
    assert drive.labels == ("Draw curve",)


def test_palings_are_shown_and_each_can_be_clicked_away(drive: EditorDriver) -> None:
    moved(drive)
    before = edges(drive)
    assert len(before) >= 4
    x, y = before[0].points[len(before[0].points) // 2]
    drive.press(x, y, alt=True).release()
    assert drive.labels[-1] == "Leave edge out"
    drive.frame().rest()
    assert len(edges(drive)) == len(before) - 1
    assert min(np.linalg.norm(edge.points - [x, y], axis=1).min() for edge in edges(drive)) > 5
    drive.undo()
    drive.frame().rest()
    assert len(edges(drive)) == len(before)


def test_all_of_them_can_be_switched_off(drive: EditorDriver) -> None:
    moved(drive)
    TABLE.run("retexture.edges", drive.editor)
    drive.frame().rest()
    assert edges(drive) == []
    assert not drive.document.retexture.long_edges


def test_what_is_regrown_is_told_from_what_is_only_deformed(drive: EditorDriver) -> None:
    moved(drive)
    stage = drive.editor.regrowth.stage
    assert stage is not None
    assert np.array_equal(stage.regrown.array > 0, stage.found.label > 0)
    assert 0 < (stage.regrown.array > 0).mean() < 0.5
