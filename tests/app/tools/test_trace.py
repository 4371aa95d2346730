"""Curves along edges: traced, cut out, outlined and suggested."""

from dataclasses import replace

import numpy as np
import pytest

from app.actions.table import ActionTable
from app.model.jobs import InlineExecutor, Jobs
from app.tools.all import TOOLS
from core.arrays import Points
from core.curves.bezier import Curve
from core.document.document import Document, pixels_from_places
from core.imaging.image import Image
from tests.app.driver import EditorDriver, Later
from tests.app.retexture.driver import HEIGHT, WIDTH, driver, moved


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
    assert drive.editor.session.tool == "feature-curves"
    assert drive.editor.session.selected_curve == 0
    pair = drive.document.feature_curves[0]
    assert pair.closed
    assert off_circle(pair.source) < 3


@pytest.mark.parametrize(
    ("first", "last", "fault"),
    [((-9, -9), (260, 200), "no ground"), ((10, 10), (14, 11), "too small"), ((2, 2), (20, 20), "Nothing stands out")],
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


def test_a_curve_that_was_taken_is_dragged_though_tracing_goes_on() -> None:
    drive = blob()
    ActionTable(TOOLS).run("feature.suggest", drive.editor)
    drive.frame().click(145, 75)
    taken = drive.document.feature_curves[0]
    drive.press(145, 75).move(150, 75).move(160, 75)
    assert drive.editor.is_busy
    assert drive.editor.session.band is None
    drive.release()
    assert drive.labels == ("Take suggested curve", "Move curve point")
    pair = drive.document.feature_curves[0]
    assert np.array_equal(pair.source, taken.source)
    assert pixels_from_places((WIDTH, HEIGHT), pair.target)[:, 0].max() > 155
    assert drive.editor.session.tool == "feature-curves"


def test_escape_puts_back_a_curve_that_is_dragged_while_tracing() -> None:
    drive = blob()
    drive.click(55, 75).click(98, 31).click(144, 76).key("enter")
    before = drive.document
    drive.tool("trace").press(98, 30).move(98, 25).move(98, 5).key("escape")
    assert drive.document is before
    assert not drive.editor.is_busy


def test_what_is_painted_becomes_a_curve() -> None:
    drive = blob()
    table = ActionTable(TOOLS)
    table.run("retexture.paint_matte", drive.editor)
    drive.editor.show(brush=replace(drive.editor.session.brush, diameter_px=60))
    drive.drag((60, 75), (140, 75))
    assert table.run("feature.outline", drive.editor)
    pair = drive.document.feature_curves[0]
    assert pair.closed
    assert drive.labels[-1] == "Outline mask"
    points = pixels_from_places((WIDTH, HEIGHT), pair.source)
    assert np.allclose(points.min(axis=0), (30, 45), atol=8)
    assert np.allclose(points.max(axis=0), (170, 105), atol=8)


def test_tracing_a_moved_picture_begins_by_showing_the_original() -> None:
    drive = moved(driver()).tool("trace")
    drive.editor.show(look="retextured")
    drive.click(60, 40)
    assert drive.editor.session.look == "original"
    assert drive.in_("trace.idle")


def test_a_curve_traced_on_a_moved_picture_goes_along_with_it() -> None:
    drive = moved(driver()).tool("trace")
    drive.click(70, 80).click(130, 80, ctrl=True).key("enter")
    assert drive.labels[-1] == "Trace curve"
    pair = drive.document.feature_curves[-1]
    source, target = (pixels_from_places((WIDTH, HEIGHT), points) for points in (pair.source, pair.target))
    assert np.allclose(source[:, 1], 80, atol=0.01)
    assert (target[:, 1] > 84).all()
    assert np.abs(drive.editor.regrowth.mesh.canvas_from_image(source[::3]) - target[::3]).max() < 1


def test_the_outline_of_a_matte_on_a_moved_picture_lies_where_it_was_painted() -> None:
    drive, table = moved(driver()), ActionTable(TOOLS)
    table.run("retexture.paint_matte", drive.editor)
    drive.editor.show(brush=replace(drive.editor.session.brush, diameter_px=24))
    drive.drag((70, 92), (130, 92))
    seen_through = drive.editor.regrowth.mesh
    assert table.run("feature.outline", drive.editor)
    pair = drive.document.feature_curves[-1]
    source, target = (pixels_from_places((WIDTH, HEIGHT), points) for points in (pair.source, pair.target))
    assert np.abs(np.array([target[:, 1].min(), target[:, 1].max()]) - (80, 104)).max() < 4
    assert np.abs(seen_through.image_from_canvas(target[::3]) - source[::3]).max() < 0.1
    assert (source[:, 1] < target[:, 1] - 2).all()


def test_a_closed_target_turned_over_is_refused_in_words() -> None:
    drive = blob().tool("feature-curves")
    drive.click(60, 50).click(140, 50).click(100, 110).click(61, 51).key("a", ctrl=True)
    pair = drive.document.feature_curves[0]
    turned = pair.target * [-1, 1] + [1, 0]
    drive.editor.edit("Turn over", drive.document.changed(feature_curves=(replace(pair, target=turned),)))
    assert "opposite directions" in (drive.frame().editor.fault or "")


@pytest.mark.parametrize("action", ["suggest", "outline"])
def test_what_is_found_after_the_mode_was_left_leaves_the_tools_alone(action: str) -> None:
    later = Later()
    drive = driver(Jobs(live=InlineExecutor(), long=later, beside=InlineExecutor()), blob().document).tool("trace")
    if action == "suggest":
        ActionTable(TOOLS).run("feature.suggest", drive.editor)
    else:
        drive.drag((40, 20), (100, 60), (160, 130))
    drive.editor.choose_mode("warp")
    later.run()
    drive.frame()
    assert not drive.editor.jobs.long_jobs
    assert drive.editor.session.mode == "warp"
    assert "warp" in drive.editor.tool.modes
    assert len(drive.document.feature_curves) == (0 if action == "suggest" else 1)


def test_a_trace_clings_to_an_edge_that_leads_far_away() -> None:
    y, x = np.mgrid[:90, :700]
    edge = 45 + 20 * np.sin(x / 60)
    noise = np.random.default_rng(0).integers(0, 12, (90, 700))
    image = Image(np.repeat((np.where(y > edge, 50, 190) + noise)[..., None], 3, axis=2).astype(np.uint8))
    drive = driver(document=Document.of(image).with_warp(cell_px=8.0)).tool("trace")
    drive.click(20, 52).click(650, 26).key("enter")
    curve = Curve(pixels_from_places((700, 90), drive.document.feature_curves[0].source))
    places = curve.at(curve.parameters(step=2.0))
    assert np.ptp(places[:, 0]) == pytest.approx(630, abs=3)
    off = np.abs(places[:, 1] - 45 - 20 * np.sin(places[:, 0] / 60))
    assert off.max() < 4
