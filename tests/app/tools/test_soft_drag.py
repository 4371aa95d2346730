"""A curve of many points gives way to the one that is pulled."""

import numpy as np
import pytest

from app.tools.curves.soft_drag import REACH, with_knot_pulled
from core.arrays import Points
from core.curves import curve_edit
from core.curves.bezier import Curve
from core.document.document import CurvePair, pixels_from_places, places_from_pixels
from tests.app.driver import EditorDriver
from tests.app.retexture.driver import HEIGHT, WIDTH, driver, start

BY = np.array([3.0, -24.0])


def wavy(count: int) -> Points:
    """Return an open curve of `count` smooth segments across the picture."""
    x = np.linspace(20, 180, count + 1)
    knots = np.column_stack([x, 75 + 6 * np.sin(x / 18)])
    handles = 160 / count / 3 * np.column_stack([np.ones_like(x), np.cos(x / 18) / 3])
    return joined(knots, handles)


def joined(knots: Points, handles: Points) -> Points:
    """Return the smooth curve through `knots` (n, 2) with a handle by `handles` (n, 2) after, and one before, each."""
    points = np.zeros((3 * len(knots) - 2, 2))
    points[::3], points[1::3], points[2::3] = knots, (knots + handles)[:-1], (knots - handles)[1:]
    return points


def ring() -> Points:
    """Return a closed curve of twelve segments around the picture's middle."""
    turns = 2 * np.pi * (np.arange(13) % 12) / 12
    out, along = np.column_stack([np.cos(turns), np.sin(turns)]), np.column_stack([-np.sin(turns), np.cos(turns)])
    return joined((100, 75) + 45 * out, 45 * 4 / 3 * np.tan(np.pi / 24) * along)


def test_what_is_near_goes_along_by_less_and_less() -> None:
    points = wavy(16)
    moved = with_knot_pulled(points, 8, BY, closed=False) - points
    share = moved[::3] @ BY / (BY @ BY)
    assert share[8] == pytest.approx(1)
    assert (np.diff(share[:9]) >= 0).all()
    assert (np.diff(share[8:]) <= 0).all()
    assert 0.5 < share[7] < 1
    near = np.abs(points[::3, 0] - points[24, 0]) < REACH * np.hypot(*BY) / 2
    assert (share[near] > 0.2).all()
    assert share[0] == share[-1] == 0


@pytest.mark.parametrize("closed", [False, True])
def test_smooth_knots_stay_smooth(closed: bool) -> None:
    points = ring() if closed else wavy(16)
    moved = with_knot_pulled(points, 0 if closed else 8, 2 * BY, closed=closed)
    for knot in range(0 if closed else 1, curve_edit.knots_of(points, closed=closed) - (not closed)):
        before, after = curve_edit.handles_at(moved, knot, closed=closed)
        assert curve_edit.is_straight(moved[before], moved[3 * knot], moved[after]), knot
    if closed:
        assert np.array_equal(moved[0], moved[-1])


def test_a_pull_that_reaches_no_neighbour_moves_one_knot_alone() -> None:
    points = wavy(4)
    by = np.array([0.0, 8.0])
    expected = curve_edit.with_knots_moved(points, {2}, by, closed=False)
    assert np.allclose(with_knot_pulled(points, 2, by, closed=False), expected)


def edited(count: int) -> EditorDriver:
    """Begin with a curve of `count` segments in hand."""
    line = places_from_pixels((WIDTH, HEIGHT), wavy(count))
    drive = driver(document=start().changed(feature_curves=(CurvePair(line, line),)))
    drive.editor.show(selected_curve=0, auto_retexture=False)
    return drive


def shifts(drive: EditorDriver, count: int) -> Points:
    """Return how far the target's knots have been moved."""
    target = pixels_from_places((WIDTH, HEIGHT), drive.document.feature_curves[0].target)
    return np.asarray((target - wavy(count))[::3])


@pytest.mark.parametrize(("count", "moved"), [(16, 5), (3, 1)])
def test_a_knot_takes_a_dense_curve_along_and_a_sparse_one_not(count: int, moved: int) -> None:
    drive = edited(count)
    x, y = wavy(count)[3 * (count // 2)].tolist()
    drive.drag((x, y), (x, y - 10), (x, y - 20))
    lifted = shifts(drive, count)[:, 1]
    assert lifted[count // 2] == pytest.approx(-20, abs=0.1)
    assert np.count_nonzero(lifted < -1) == moved if moved == 1 else np.count_nonzero(lifted < -1) >= moved
    assert drive.labels == ("Move curve point",)


def test_selected_knots_move_as_one_and_leave_the_others() -> None:
    drive = edited(16)
    drive.editor.show(selected_knots=frozenset({7, 8}))
    x, y = wavy(16)[24].tolist()
    drive.drag((x, y), (x, y - 10), (x, y - 20))
    assert np.flatnonzero(np.abs(shifts(drive, 16)[:, 1]) > 0.1).tolist() == [7, 8]


def test_the_line_of_a_dense_curve_is_pulled_without_a_spike() -> None:
    drive = edited(6)
    drive.editor.show(selected_curve=None)
    x, y = Curve(wavy(6)).at(np.array([2.5]))[0].tolist()
    drive.drag((x, y), (x, y - 10), (x, y - 20))
    lifted = shifts(drive, 6)[:, 1]
    assert lifted.min() == pytest.approx(-20, abs=0.1)
    assert np.abs(np.diff(lifted)).max() < 15
    assert drive.labels == ("Bend curve",)
