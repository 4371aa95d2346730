"""Curves keep their shape under splitting, fitting and cutting, and refuse what makes no curve."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from core.arrays import Floats, InputError, Points
from core.curves.bezier import Curve, crossings, pair_parameters
from core.curves.feature_curves import FeatureCurve, disjoint, from_data, read
from core.curves.fitting import fit

coordinates = st.floats(-100, 100).map(lambda v: round(v, 3))
control = st.integers(1, 3).flatmap(lambda k: arrays(np.float64, (3 * k + 1, 2), elements=coordinates))


def curve_of(points: Points) -> Curve | None:
    try:
        return Curve(points)
    except InputError:
        return None


def line(*ends: tuple[float, float]) -> Curve:
    a, b = np.array(ends[0], float), np.array(ends[1], float)
    return Curve(a + np.linspace(0, 1, 4)[:, None] * (b - a))


def circle(radius: float, centre: tuple[float, float] = (0, 0)) -> Curve:
    angle = np.linspace(0, 2 * np.pi, 200)
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * radius + centre
    ring[-1] = ring[0]
    return fit(ring, tolerance=0.05, closed=True)


@given(control)
def test_no_gap_is_longer_than_the_step(points: Points) -> None:
    curve = curve_of(points)
    if curve is None:
        return
    dense = curve.at(curve.parameters(step=0.5))
    assert np.hypot(*np.diff(dense, axis=0).T).max() <= 0.5 + 1e-9
    np.testing.assert_allclose(dense[[0, -1]], points[[0, -1]], atol=1e-9)


@given(control, st.floats(0, 1))
def test_an_inserted_knot_changes_no_point(points: Points, share: float) -> None:
    curve = curve_of(points)
    if curve is None:
        return
    t = share * curve.segments
    more = curve.insert_knot(t)
    assert more.segments == curve.segments + 1
    np.testing.assert_allclose(more.at(float(min(int(t), curve.segments - 1) + 1)), curve.at(t), atol=1e-9)
    there = np.linspace(0, more.segments, 17)
    _, off = curve.nearest(more.at(there))
    assert off.max() < 0.3


def test_a_piece_runs_along_the_whole() -> None:
    curve = Curve(np.array([[0, 0], [20, 40], [50, -30], [70, 10], [90, 50], [110, 0], [130, 20]], float))
    for start, end in [(0.2, 0.7), (0.0, 2.0), (0.6, 1.0), (1.0, 1.4), (0.5, 1.9)]:
        piece = curve.between(start, end)
        np.testing.assert_allclose(piece.at(0.0), curve.at(start), atol=1e-9)
        np.testing.assert_allclose(piece.at(float(piece.segments)), curve.at(end), atol=1e-9)
        assert curve.nearest(piece.at(piece.parameters()))[1].max() < 1e-3


def test_tangent_where_a_handle_lies_on_its_knot() -> None:
    curve = Curve(np.array([[0, 0], [0, 0], [6, 8], [6, 8]], float))
    np.testing.assert_allclose(curve.tangent(np.array([0.0, 0.5, 1.0])), np.full((3, 2), [0.6, 0.8]), atol=1e-3)


def test_normal_is_to_the_right_on_screen() -> None:
    np.testing.assert_allclose(line((0, 0), (9, 0)).normal(0.5), [0, 1], atol=1e-12)


def test_length_box_and_nearest_point_of_a_circle() -> None:
    ring = circle(50, (7, 9))
    assert ring.length == pytest.approx(100 * np.pi, rel=1e-3)
    np.testing.assert_allclose(ring.box, [-43, -41, 57, 59], atol=0.3)
    t, off = ring.nearest(np.array([[7.0, 89.0], [37.0, 9.0]]))
    np.testing.assert_allclose(off, [30, 20], atol=0.1)
    np.testing.assert_allclose(ring.at(t), [[7, 59], [57, 9]], atol=0.2)


def test_arc_length_and_parameter_are_inverse() -> None:
    curve = Curve(np.array([[0, 0], [0, 90], [10, 90], [80, 0]], float))
    s = np.linspace(0, curve.length, 30)
    np.testing.assert_allclose(curve.length_at(curve.parameter_at(s)), s, atol=1e-6)


def test_reversed_runs_back() -> None:
    curve = Curve(np.array([[0, 0], [5, 40], [50, -30], [70, 10]], float))
    np.testing.assert_allclose(curve.reversed().at(0.25), curve.at(0.75), atol=1e-12)


@pytest.mark.parametrize("knots", [1, 2])
def test_paired_samples_leave_no_gap_on_either_side(knots: int) -> None:
    source = line((0, 0), (10, 0))
    target = line((0, 0), (0, 200)) if knots == 1 else line((0, 0), (0, 200)).insert_knot(0.3)
    s, t = pair_parameters(source, target)
    assert len(s) == len(t)
    assert np.hypot(*np.diff(target.at(t), axis=0).T).max() <= 0.5 + 1e-9
    np.testing.assert_allclose(source.at(s)[:, 0] / 10, target.at(t)[:, 1] / 200, atol=2e-3)


def spiral(count: int) -> Points:
    angle = np.linspace(0, 3 * np.pi, count)
    return np.column_stack([np.cos(angle), np.sin(angle)]) * (20 + 8 * angle)[:, None]


def test_fit_stays_within_its_tolerance_with_few_segments() -> None:
    curve = fit(spiral(600), tolerance=0.8)
    assert curve.nearest(spiral(600))[1].max() <= 0.8
    assert curve.segments <= 12
    tangent = curve.tangent(np.arange(1.0, curve.segments)), curve.tangent(np.arange(1.0, curve.segments) - 1e-6)
    assert (tangent[0] * tangent[1]).sum(axis=1).min() > 0.999


def test_fit_keeps_a_corner() -> None:
    leg = np.linspace(0, 60, 61)
    path = np.concatenate(
        [np.column_stack([leg, np.zeros(61)]), np.column_stack([np.full(60, 60.0), leg[1:]])],
    )
    curve = fit(path, tolerance=0.5)
    assert np.hypot(*(curve.knots - [60, 0]).T).min() < 1e-9


def test_fit_of_a_closed_line_has_no_kink_at_its_seam() -> None:
    ring = circle(30)
    assert ring.closed
    assert float(ring.tangent(0.0) @ ring.tangent(float(ring.segments))) > 0.99


@pytest.mark.parametrize("points", [[[1.0, 1.0]], [[1.0, 1.0], [1.0, 1.0]], []])
def test_fit_of_one_point_is_refused(points: list[list[float]]) -> None:
    with pytest.raises(InputError):
        fit(np.array(points))


def test_crossings_of_lines_and_of_a_loop() -> None:
    np.testing.assert_allclose(crossings(line((0, 0), (90, 0)), line((30, -7), (30, 14))), [[1 / 3, 1 / 3]], atol=1e-3)
    assert len(crossings(line((0, 0), (90, 0)), line((0, 5), (90, 5)))) == 0
    loop = Curve(np.array([[0, 0], [150, 100], [-50, 100], [100, 0]], float))
    found = crossings(loop, loop)
    assert len(found) == 1
    np.testing.assert_allclose(loop.at(found[0, 0]), loop.at(found[0, 1]), atol=0.01)
    assert len(crossings(circle(40), circle(40))) < 5


def test_no_false_crossing_on_a_closed_curve() -> None:
    ring = circle(40)
    assert len(crossings(ring, ring)) == 0


def test_crossing_targets_are_broken_into_disjoint_pieces() -> None:
    across, down = line((0, 50), (100, 50)), line((40, 0), (40, 100))
    pieces = disjoint([FeatureCurve(across, across), FeatureCurve(down, down)])
    assert len(pieces) == 4
    targets = [piece.target for piece in pieces if piece.target is not None]
    assert sum(t.length for t in targets) == pytest.approx(200 - 4 * 2, abs=0.1)
    for i, a in enumerate(targets):
        for b in targets[i:]:
            assert len(crossings(a, b)) == 0


def test_a_closed_curve_is_broken_across_its_seam() -> None:
    ring, cut = circle(40), line((0, -80), (0, 80))
    pieces = disjoint([FeatureCurve(ring, ring), FeatureCurve(cut, cut)])
    assert len(pieces) == 5
    lengths = sorted(round(p.source.length) for p in pieces)
    np.testing.assert_allclose(lengths, sorted([38, 38, 76, 122, 122]), atol=1.1)


def entry(**changes: object) -> dict[str, object]:
    points = [[0, 0], [10, 0], [20, 0], [30, 0]]
    return {"source": points, "target": points, "closed": False, "passive": False, **changes}


def test_a_file_says_what_its_data_say(tmp_path: Path) -> None:
    data = {"curves": [entry(), entry(passive=True)]}
    curves, path = from_data(data), tmp_path / "curves.json"
    path.write_text(json.dumps(data))
    again = read(path)
    assert [c.passive for c in again] == [False, True]
    np.testing.assert_array_equal(again[0].source.points, curves[0].source.points)


SQUARE = [[0, 0], [1, 0], [2, 0], [9, 0], [9, 3], [9, 6], [9, 9], [6, 9], [3, 9], [0, 9], [0, 6], [0, 3], [0, 0]]


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ([], '"curves"'),
        ({"curves": 3}, '"curves"'),
        ({"curves": [7]}, "curve 1"),
        ({"curves": [entry(), {"target": []}]}, 'curve 2: has no "source"'),
        ({"curves": [{"source": SQUARE}]}, 'curve 1: has no "target"'),
        ({"curves": [entry(source=[[0, 0]])]}, "3k + 1 control points"),
        ({"curves": [entry(source=[[3, 3]] * 4)]}, "coincide"),
        ({"curves": [entry(source=[[0, 0], [1, 1], [2], [3, 3]])]}, "pairs"),
        ({"curves": [entry(target=[[0, 0], [1, float("nan")], [2, 2], [3, 3]])]}, "NaN"),
        ({"curves": [entry(target=[[0, 0], [1, 1], [2, 2], [1e9, 3]])]}, "away"),
        ({"curves": [entry(closed=True)]}, "end where it begins"),
        ({"curves": [entry(closed="yes")]}, "true nor false"),
        ({"curves": [entry(closed=True, source=SQUARE, target=SQUARE[::-1])]}, "opposite directions"),
    ],
)
def test_bad_curves_are_named(data: object, words: str) -> None:
    with pytest.raises(InputError, match=words.replace("+", r"\+")):
        from_data(data)


@pytest.mark.parametrize("text", ["{", "", "\x00\x01", "[" * 100000])
def test_a_file_that_is_no_json_is_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "broken.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"broken\.json: not a JSON file"):
        read(path)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nothing\.json: no such file"):
        read(tmp_path / "nothing.json")


def test_points_cannot_be_written_to() -> None:
    points: Floats = np.array([[0, 0], [1, 0], [2, 0], [3, 0]], float)
    curve = Curve(points)
    points[0] = 99
    assert curve.points[0, 0] == 0
    with pytest.raises(ValueError, match="read-only"):
        curve.points[0] = 5


@pytest.mark.parametrize("path", sorted((Path(__file__).parents[2] / "curves").glob("*.json")), ids=lambda p: p.stem)
def test_the_curves_of_the_photographs_are_sound(path: Path) -> None:
    curves = read(path)
    assert not all(curve.passive for curve in curves)
    for curve in curves:
        assert len(crossings(curve.source, curve.source)) == 0
        if curve.target is not None:
            assert curve.source.segments == curve.target.segments
            assert len(crossings(curve.target, curve.target)) == 0
