"""Curves along lines have few points, no hooks, and keep their shape when they are simplified."""

from itertools import pairwise

import numpy as np
import pytest

from core.arrays import Points
from core.curves.bezier import Curve
from core.curves.edge_tracing import smooth
from core.curves.fitting import fit
from core.document.curves.simplifying import simplify_pair
from core.document.document import CurvePair

SIZE = (400, 300)


def wave(count: int, *, height: float = 40.0) -> Points:
    """Return a line of one period of a sine, 300 px wide."""
    x = np.linspace(0, 300, count)
    return np.column_stack([50 + x, 150 + height * np.sin(2 * np.pi * x / 300)])


def test_a_wobbling_line_of_pixels_takes_few_segments() -> None:
    random = np.random.default_rng(2)
    line = np.rint(wave(330) + random.normal(0, 0.8, (330, 2)))
    curve = fit(smooth(line), tolerance=2.0)
    assert curve.segments <= 4
    assert curve.nearest(wave(330))[1].max() < 3


def test_needless_splits_are_taken_back() -> None:
    assert fit(wave(600), tolerance=1.0).segments <= 3


def test_smoothing_leaves_the_ends_and_makes_no_hook() -> None:
    line = np.column_stack([np.arange(80.0), 0.5 * np.arange(80.0)])
    assert np.abs(smooth(line) - line).max() < 1e-9
    line[40:] += [0.0, 6.0]
    found = smooth(line)
    assert np.array_equal(found[[0, -1]], line[[0, -1]])
    assert np.abs(np.diff(found[:5] @ [0.5, -1.0])).max() < 1e-9


def pair_of(points: Points, target: Points, *, closed: bool = False, corners: tuple[int, ...] = ()) -> CurvePair:
    return CurvePair(points / SIZE, target / SIZE, closed=closed, corners=frozenset(corners))


def crowded(times: int) -> tuple[Curve, CurvePair]:
    """Return a wave and it with many points, its target turned and moved elsewhere."""
    curve = fit(wave(600), tolerance=0.3)
    full = curve
    for number in range(times):
        full = full.insert_knot(0.37 + number * 0.9)
    turned = full.points @ np.array([[0.8, 0.3], [-0.3, 0.8]]) + [90.0, -20.0]
    return curve, pair_of(full.points, turned, corners=(0, full.segments))


def test_a_simplified_curve_and_its_target_stay_where_they_are_and_keep_corresponding() -> None:
    _, pair = crowded(6)
    simpler = simplify_pair(pair, SIZE, tolerance_px=1.0)
    assert len(simpler.source) == len(simpler.target) < len(pair.source) / 2
    before, after = ([Curve(side * SIZE) for side in (p.source, p.target)] for p in (pair, simpler))
    for old, new in zip(before, after, strict=True):
        assert new.nearest(old.at(old.parameters(step=2.0)))[1].max() < 1.1
    t = np.linspace(0, after[0].segments, 50)
    there = after[0].at(t) @ np.array([[0.8, 0.3], [-0.3, 0.8]]) + [90.0, -20.0]
    assert np.abs(there - after[1].at(t)).max() < 2
    assert simpler.corners == {0, after[0].segments}


def test_corners_stay_when_a_curve_is_simplified() -> None:
    legs = np.array([(50.0, 50.0), (200.0, 60.0), (210.0, 220.0)])
    curve = Curve(np.concatenate([legs[:1], *(np.linspace(a, b, 4)[1:] for a, b in pairwise(legs))]))
    full = curve.insert_knot(0.5).insert_knot(2.5)
    assert np.allclose(full.knots[2], legs[1])
    simpler = simplify_pair(pair_of(full.points, full.points, corners=(0, 2, 4)), SIZE, tolerance_px=1.0)
    assert np.allclose(simpler.source[::3] * SIZE, legs)
    assert simpler.corners == {0, 1, 2}


def test_a_closed_curve_stays_closed_and_smooth() -> None:
    angle = np.linspace(0, 2 * np.pi, 400)
    ring = fit(np.column_stack([200 + 90 * np.cos(angle), 150 + 60 * np.sin(angle)]), tolerance=0.1, closed=True)
    full = ring.insert_knot(0.4).insert_knot(1.6).insert_knot(3.1)
    simpler = simplify_pair(pair_of(full.points, full.points, closed=True), SIZE, tolerance_px=1.0)
    assert 7 <= len(simpler.source) < len(full.points)
    curve = Curve(simpler.source * SIZE, closed=True)
    assert float(curve.tangent(0.0) @ curve.tangent(float(curve.segments))) > 0.99
    assert curve.nearest(ring.at(ring.parameters(step=2.0)))[1].max() < 1.1


def test_a_curve_that_needs_its_points_stays_as_it_is() -> None:
    points = np.array([(50, 50), (120, -80), (190, 260), (330, 60)], float)
    pair = pair_of(points, points)
    assert simplify_pair(pair, SIZE, tolerance_px=1.0) is pair


@pytest.mark.parametrize("tolerance", [0.5, 3.0])
def test_a_point_folded_onto_its_handles_does_no_harm(tolerance: float) -> None:
    points = np.array([(50, 50), (50, 50), (90, 50), (90, 50), (90, 50), (150, 80), (150, 80)], float)
    simpler = simplify_pair(pair_of(points, points + [0.0, 40.0], corners=(0, 2)), SIZE, tolerance_px=tolerance)
    assert np.isfinite(simpler.source).all()
    assert np.isfinite(simpler.target).all()
