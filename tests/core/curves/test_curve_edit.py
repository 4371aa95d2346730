import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from core.arrays import Points
from core.curves import curve_edit
from core.curves.bezier import Curve


def wavy(segments: int, *, closed: bool, seed: int = 1) -> Points:
    points = np.random.default_rng(seed).uniform(0, 100, (3 * segments + 1, 2))
    if closed:
        points[-1] = points[0]
    return points


curves = st.tuples(st.integers(2, 5), st.booleans(), st.integers(0, 99))
vectors = arrays(np.float64, 2, elements=st.floats(-50, 50))


@given(curves, st.integers(0, 9), vectors)
def test_a_knot_moves_with_its_handles_and_nothing_else(kind: tuple[int, bool, int], knot: int, by: Points) -> None:
    segments, closed, seed = kind
    points = wavy(segments, closed=closed, seed=seed)
    knot %= curve_edit.knots_of(points, closed=closed)
    moved = curve_edit.with_knots_moved(points, {knot}, by, closed=closed)
    changed = {3 * knot, *(n for n in curve_edit.handles_at(points, knot, closed=closed) if n is not None)}
    changed |= {len(points) - 1} if closed and knot == 0 else set()
    for number in range(len(points)):
        assert np.allclose(moved[number] - points[number], by if number in changed else 0)


@given(curves, vectors)
def test_moving_all_knots_moves_the_curve(kind: tuple[int, bool, int], by: Points) -> None:
    segments, closed, seed = kind
    points = wavy(segments, closed=closed, seed=seed)
    all_knots = set(range(curve_edit.knots_of(points, closed=closed)))
    assert np.allclose(curve_edit.with_knots_moved(points, all_knots, by, closed=closed), points + by)


@given(curves, st.integers(0, 99), vectors)
def test_a_linked_handle_turns_with_the_one_across(kind: tuple[int, bool, int], pick: int, place: Points) -> None:
    segments, closed, seed = kind
    points = wavy(segments, closed=closed, seed=seed)
    handle = [n for n in range(len(points)) if n % 3][pick % (2 * segments)]
    knot = curve_edit.knot_beside(points, handle, closed=closed)
    moved = curve_edit.with_handle_at(points, handle, place, closed=closed, linked=True)
    assert np.array_equal(moved[handle], place)
    before, after = curve_edit.handles_at(points, knot, closed=closed)
    assert handle in (before, after)
    if before is not None and after is not None:
        centre = points[3 * knot]
        other = after if handle == before else before
        assert np.hypot(*(moved[other] - centre)) == pytest.approx(np.hypot(*(points[other] - centre)))
        assert curve_edit.is_straight(moved[before], centre, moved[after])
    alone = curve_edit.with_handle_at(points, handle, place, closed=closed, linked=False)
    assert (alone != points).any(axis=1).sum() == 1


@given(curves, st.floats(0.1, 0.9), vectors)
def test_bending_takes_the_gripped_point_along(kind: tuple[int, bool, int], u: float, by: Points) -> None:
    segments, closed, seed = kind
    points = wavy(segments, closed=closed, seed=seed)
    t = 1 + u
    moved = curve_edit.bent(points, t, by)
    assert np.allclose(Curve(moved).at(t) - Curve(points).at(t), by)
    assert np.array_equal(moved[::3], points[::3])


@pytest.mark.parametrize("closed", [False, True])
def test_bending_keeps_smooth_knots_smooth_and_leaves_corners_alone(closed: bool) -> None:
    smooth = {1, 2}
    points = wavy(4, closed=closed)
    for knot in smooth:
        points = curve_edit.smooth_knot(points, knot, closed=closed)
    by = np.array([3.0, -14.0])
    moved = curve_edit.bent(points, 1.4, by, closed=closed, smooth=smooth)
    assert np.allclose(Curve(moved).at(1.4) - Curve(points).at(1.4), by)
    for knot in smooth:
        before, after = curve_edit.handles_at(points, knot, closed=closed)
        assert before is not None
        assert after is not None
        assert curve_edit.is_straight(moved[before], moved[3 * knot], moved[after])
    free = curve_edit.bent(points, 1.4, by, closed=closed, smooth={1})
    assert np.array_equal(free[7:], points[7:])
    assert not np.array_equal(free[2], points[2])


def test_at_a_knot_bending_stays_mild() -> None:
    points = wavy(2, closed=False)
    assert np.abs(curve_edit.bent(points, 0.0, np.array([10.0, 0.0])) - points).max() < 80


@pytest.mark.parametrize("closed", [False, True])
def test_a_knot_that_was_inserted_can_go_again(closed: bool) -> None:
    points = wavy(3, closed=closed)
    for knot in range(1, 4):
        more = Curve(points, closed).insert_knot(knot - 0.5).points
        fewer = curve_edit.without_knot(more, knot, closed=closed)
        assert fewer is not None
        assert len(fewer) == len(points)
        assert {tuple(k) for k in fewer[::3].round(6)} == {tuple(k) for k in points[::3].round(6)}


@pytest.mark.parametrize("closed", [False, True])
def test_knots_go_one_by_one_until_none_is_left(closed: bool) -> None:
    points: Points | None = wavy(4, closed=closed)
    for left in range(curve_edit.knots_of(wavy(4, closed=closed), closed=closed) - 1, 1, -1):
        assert points is not None
        points = curve_edit.without_knot(points, 0, closed=closed)
        assert points is not None
        assert curve_edit.knots_of(points, closed=closed) == left
        assert not closed or np.array_equal(points[0], points[-1])
    assert points is not None
    assert curve_edit.without_knot(points, 0, closed=closed) is None


def test_corners_keep_their_knots() -> None:
    assert curve_edit.corners_without({0, 2, 4}, 2) == {0, 3}
    assert curve_edit.corners_with({0, 2, 4}, 2) == {0, 3, 5}


@given(curves, st.integers(0, 9))
def test_smooth_is_straight_and_a_corner_points_at_its_neighbours(kind: tuple[int, bool, int], knot: int) -> None:
    segments, closed, seed = kind
    points = wavy(segments, closed=closed, seed=seed)
    count = curve_edit.knots_of(points, closed=closed)
    knot %= count
    before, after = curve_edit.handles_at(points, knot, closed=closed)
    smooth = curve_edit.smooth_knot(points, knot, closed=closed)
    if before is not None and after is not None and not (closed and count == 2):
        assert curve_edit.is_straight(smooth[before], smooth[3 * knot], smooth[after])
    sharp = curve_edit.make_corner(points, knot, closed=closed)
    if after is not None:
        following = points[3 * ((knot + 1) % count)]
        assert np.allclose(sharp[after], points[3 * knot] + (following - points[3 * knot]) / 3)


@given(curves)
def test_a_curve_is_refitted_exactly_and_follows_an_affine_map(kind: tuple[int, bool, int]) -> None:
    segments, closed, seed = kind
    points = wavy(segments, closed=closed, seed=seed)
    line = curve_edit.samples_of(points)
    assert np.allclose(curve_edit.map_along(points, line), points)
    matrix = np.array([[1.5, 0.3], [-0.2, 0.8]])
    assert np.allclose(curve_edit.map_along(points, line @ matrix + 7), points @ matrix + 7)


def test_a_curve_folded_into_a_point_is_sampled_there() -> None:
    points = np.full((7, 2), 4.0)
    assert (curve_edit.samples_of(points, per_segment=5) == 4.0).all()
    assert curve_edit.samples_of(points, per_segment=5).shape == (10, 2)
    assert curve_edit.curve_through(points) is None
    assert np.allclose(curve_edit.map_along(points, curve_edit.samples_of(points) + 1), 5.0)
