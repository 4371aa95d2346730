"""The outline snaps to frame and corners, and is edited on both sides alike."""

from dataclasses import replace

import numpy as np
import pytest

from app.model.session import OutlineAids
from app.tools.outline_aids import mirror
from core.arrays import Points
from tests.app.driver import EditorDriver
from tests.app.tools.test_outline import CORNERS, at, ring

WIDTH, HEIGHT = 200, 150


@pytest.fixture
def drive() -> EditorDriver:
    drive = EditorDriver().tool("outline")
    drive.editor.show(view=replace(drive.editor.session.view, pan=(100.0, 100.0)))
    return drive


def corners(drive: EditorDriver) -> Points:
    return np.array(ring(drive))[::3]


def test_a_corner_comes_level_with_the_others_and_onto_the_frame(drive: EditorDriver) -> None:
    drive.drag(at(-0.5, -0.5), at(40, 30), at(53, 33))
    drive.drag(at(53, 33), at(40, 20), at(30, 3)).drag(at(199.5, -0.5), at(180, -20), at(160, -34))
    assert corners(drive)[0] == pytest.approx((30, -0.5), abs=1e-3)
    drive.drag(at(30, -0.5), at(30, -20), at(33, -30))
    assert corners(drive)[0] == pytest.approx((33, -34), abs=1e-3)


def test_a_line_leads_to_what_a_corner_snaps_to_while_it_is_dragged(drive: EditorDriver) -> None:
    drive.move(*at(-0.5, -0.5)).press(*at(-0.5, -0.5)).move(*at(40, 30)).move(*at(60, 70))
    ((point, place),) = drive.editor.session.guides
    assert place == pytest.approx(at(60, 74.5), abs=1e-3)
    assert point[1] == pytest.approx(174.5, abs=1e-3)
    drive.release()
    assert drive.editor.session.guides == ()


@pytest.mark.parametrize("way", ["switched off", "Ctrl held"])
def test_without_snapping_a_corner_lies_where_it_is_dragged(drive: EditorDriver, way: str) -> None:
    if way == "switched off":
        drive.editor.show(outline=OutlineAids(snaps=False))
    drive.drag(at(-0.5, -0.5), at(40, 30), at(60, 70), ctrl=way == "Ctrl held")
    assert corners(drive)[0] == pytest.approx((59.5 + 0.0, 69.5), abs=0.6)


def test_a_bent_side_snaps_back_to_straight(drive: EditorDriver) -> None:
    drive.drag(at(100, 149.5), at(100, 180))
    assert drive.document.outline is not None
    drive.drag(at(100, 180), at(100, 170), at(100, 152))
    assert np.allclose(np.array(ring(drive))[6:10, 1], 149.5, atol=0.01)


def test_with_shift_snapping_leaves_the_axis_alone(drive: EditorDriver) -> None:
    drive.drag(at(-0.5, -0.5), at(60, 40))
    drive.drag(at(60, 40), at(80, 41), at(97, 42), shift=True)
    assert corners(drive)[0] == pytest.approx((99.5, 40), abs=1e-3)


@pytest.mark.parametrize("preset", [None, "perspective"])
def test_left_and_right_are_edited_alike(drive: EditorDriver, preset: str | None) -> None:
    drive.editor.edit("Preset", drive.document.with_warp(preset=preset))
    drive.editor.show(outline=OutlineAids(across=True))
    drive.drag(at(-0.5, -0.5), at(20, 20), at(30, 40))
    assert np.allclose(corners(drive), [(30, 40), (169, 40), *CORNERS[2:]], atol=0.6)
    assert (drive.document.outline is None) == (preset is not None)
    drive.key("down")
    assert np.allclose(corners(drive)[:2, 1], 41, atol=0.6)
    assert drive.undo().undo().document.outline is None


def test_all_four_corners_go_in_together(drive: EditorDriver) -> None:
    drive.editor.show(outline=OutlineAids(across=True, down=True))
    drive.drag(at(199.5, -0.5), at(180, 20), at(169, 40))
    assert np.allclose(corners(drive), [(30, 40), (169, 40), (169, 109), (30, 109)], atol=0.6)


def test_a_bent_side_bends_its_opposite_outwards_too(drive: EditorDriver) -> None:
    drive.editor.show(outline=OutlineAids(down=True))
    drive.drag(at(100, -0.5), at(100, -20), at(100, -40))
    found = np.array(ring(drive))
    assert found[1:3, 1].max() < -40
    assert np.allclose(found[[8, 7], 1] - 149.5, -0.5 - found[[1, 2], 1], atol=1e-3)


def test_moves_are_mirrored_and_not_places() -> None:
    rng = np.random.default_rng(3)
    before = rng.normal(size=(13, 2))
    before[12] = before[0]
    after = before.copy()
    after[[0, 12]] += (2.0, 5.0)
    moved = mirror(before, after, OutlineAids(across=True)) - before
    assert np.allclose(moved[[0, 3, 12]], [(2, 5), (-2, 5), (2, 5)])
    assert not moved[[1, 2, *range(4, 12)]].any()
    assert np.array_equal(mirror(before, after, OutlineAids()), after)
