"""What Retexture mode says of curves that lead nowhere, and how far its work is."""

import numpy as np
import pytest

from app.actions.table import ActionTable
from app.model.jobs import InlineExecutor, Jobs
from app.model.shapes import Bezier
from app.tools.all import TOOLS
from app.tools.marks import marks
from core.arrays import Points
from core.document.document import CurvePair, places_from_pixels
from core.rasters.raster import Raster
from tests.app.driver import EditorDriver, Later
from tests.app.retexture.driver import HEIGHT, WIDTH, drawn, driver, moved, shown, start


@pytest.fixture
def drive() -> EditorDriver:
    return driver()


ODD: dict[str, list[tuple[float, float]]] = {
    "crosses itself": [(20, 40), (260, 140), (-60, 140), (180, 40)],
    "is folded tightly": [(20, 60), (240, 60), (240, 61), (20, 61)],
    "runs backwards": [(180, 60), (130, 60), (70, 60), (20, 60)],
    "lies partly outside": [(90, 60), (150, 90), (250, 90), (400, 60)],
    "has coincident points": [(20, 50), (20, 50), (160, 90), (160, 90)],
    "lies on the other one": [(20, 110), (70, 110), (130, 110), (180, 110)],
}


@pytest.mark.parametrize("target", list(ODD.values()), ids=list(ODD))
def test_a_target_that_is_odd_gives_a_picture_and_no_fault(target: list[tuple[float, float]]) -> None:
    def places(*points: tuple[float, float]) -> Points:
        return places_from_pixels((WIDTH, HEIGHT), np.array(points, float))

    line = places((20, 40), (70, 40), (130, 40), (180, 40))
    other = places((20, 90), (70, 90), (130, 90), (180, 90))
    pairs = (CurvePair(line, places(*target)), CurvePair(other, other + [0, 20 / HEIGHT]))
    drive = driver(document=start().changed(feature_curves=pairs)).frame()
    assert drive.editor.fault is None
    assert drive.editor.regrowth.is_final
    result = shown(drive).pixels
    assert result.min() >= drive.document.image.pixels.min()
    assert result.std() > 10
    assert [s for s in marks(drive.editor) if isinstance(s, Bezier) and s.role == "target"]


NOWHERE: dict[str, tuple[list[tuple[float, float]], str]] = {
    "a point": ([(90, 60)] * 4, "coincide"),
    "shorter than a patch": ([(90, 60), (91, 60), (92, 60), (92, 60)], "shorter than"),
    "outside": ([(-90, 60), (-80, 70), (-70, 80), (-60, 90)], "outside the picture"),
}


@pytest.mark.parametrize(("target", "words"), list(NOWHERE.values()), ids=list(NOWHERE))
def test_a_target_that_leads_nowhere_is_told_in_words_and_can_be_mended(
    target: list[tuple[float, float]], words: str
) -> None:
    line = places_from_pixels((WIDTH, HEIGHT), np.linspace((20, 40), (180, 40), 4))
    drive = driver()
    good = drive.document.changed(feature_curves=(CurvePair(line, line),))
    drive.editor.edit("Draw", good)
    lost = places_from_pixels((WIDTH, HEIGHT), np.array(target, float))
    drive.editor.edit("Lose", good.changed(feature_curves=(CurvePair(line, lost),)))
    assert words in (drive.frame().editor.fault or "")
    assert shown(drive) is drive.document.image
    drive.undo()
    assert drive.editor.fault is None
    drive.editor.edit("Move", good.changed(feature_curves=(CurvePair(line, line + [0, 0.1]),)))
    assert drive.frame().editor.regrowth.is_final


def test_the_panel_says_how_far_the_work_is_and_what_comes_next() -> None:
    from app.ui.panels.retexture import RetexturePanel

    later, table = Later(), ActionTable(TOOLS)
    drive = driver(Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()))
    panel = RetexturePanel(drive.editor, table)
    assert "pen (C)" in panel.state
    drawn(drive)
    assert panel.state.startswith("Drag a curve")
    table.run("feature.passive", drive.editor)
    assert "switch Passive off" in panel.state
    drive.undo().drag((100, 70), (100, 90))
    assert panel.state.startswith("Working")
    drive.editor.regrowth.cancel()
    assert "not regrown yet" in panel.state
    later.run()
    drive.frame().editor.regrowth.start(drive.document)
    later.run()
    drive.frame()
    assert panel.state.startswith("The texture is regrown")
    lost = CurvePair(drive.document.feature_curves[0].source, drive.document.feature_curves[0].source + 3)
    drive.editor.edit("Lose", drive.document.changed(feature_curves=(lost,)))
    drive.frame()
    later.run()
    drive.frame()
    assert "outside the picture" in panel.state


def test_the_panel_says_that_the_masks_leave_no_texture_to_take() -> None:
    from app.ui.panels.retexture import NOTHING_FITS, RetexturePanel

    drive = moved(driver())
    panel = RetexturePanel(drive.editor, ActionTable(TOOLS))
    far = np.zeros((HEIGHT, WIDTH), np.uint8)
    far[:8, :8] = 255
    drive.editor.edit("Mask", drive.document.changed(source_mask=Raster.from_array(far)))
    drive.frame()
    assert drive.editor.regrowth.is_final
    assert panel.state == NOTHING_FITS
    drive.undo().frame()
    assert panel.state.startswith("The texture is regrown")


@pytest.mark.parametrize("way", ["a point", "outside"])
def test_the_curve_that_is_at_fault_is_marked(way: str) -> None:
    line, lost = (
        places_from_pixels((WIDTH, HEIGHT), np.array(points, float))
        for points in (np.linspace((20, 40), (180, 40), 4), NOWHERE[way][0])
    )
    drive = driver()
    good = CurvePair(line, line + [0, 0.1])
    drive.editor.edit("Lose", drive.document.changed(feature_curves=(good, CurvePair(line, lost))))
    drive.frame()
    assert (drive.editor.fault or "").startswith("curve 2: ")
    assert [shape.role for shape in curves_drawn(drive)] == ["source", "target", "faulty", "faulty"]
    drive.undo()
    drive.editor.edit("Draw", drive.document.changed(feature_curves=(good,)))
    drive.frame()
    assert [shape.role for shape in curves_drawn(drive)] == ["source", "target"]


def curves_drawn(drive: EditorDriver) -> list[Bezier]:
    return [shape for shape in drive.editor.tool.overlay(drive.editor) if isinstance(shape, Bezier)]
