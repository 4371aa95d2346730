"""Straight lines beside features: how straight they come out, what they leave alone, and that it is a least energy."""

from typing import Any

import cv2
import numpy as np
import pytest

from core.arrays import Bytes, Floats, Points
from core.grid import Grid, find_features
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.limits import FREE, Limits
from core.mapping.features.straight_lines import Lines, LineSolver, _sample
from core.mapping.handles.handles import Handles
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.options import MappingOptions
from core.mapping.result import Warped
from core.mapping.warper import Warper
from core.mapping.warping import warp_grid
from core.progress import run
from core.warps.presets import make_warp

SIZE = 300, 200
GRID = Grid(*SIZE, cell_px=4)
ENDS = np.array([[[5.0, 60.0], [290.0, 66.0]], [[40.0, 10.0], [44.0, 190.0]], [[120.0, 185.0], [250.0, 180.0]]])
WARPS = {
    "narrow": GRID.nodes * [0.6, 1.0],
    "wide": GRID.nodes * [1.5, 1.0],
    "twist": make_warp("twist", *SIZE, bend=40)(GRID.nodes),
    "arch": make_warp("arch", *SIZE, bend=20)(GRID.nodes),
}


def mask() -> Bytes:
    found = np.zeros(SIZE[::-1], np.uint8)
    cv2.circle(found, (80, 110), 34, 255, -1)
    cv2.circle(found, (200, 120), 40, 255, -1)
    return found


def warped(plain: Points, lines: Lines | None, painted: Bytes | None = None) -> Warped:
    features = find_features(GRID, mask() if painted is None else painted)
    return warp_grid(GRID, features, plain, options=MappingOptions(lines=lines))


def places(z: Points, at: Points) -> Points:
    nodes, weights = GRID.weights_at(at)
    return np.asarray((z.reshape(-1, 2)[nodes] * weights[..., None]).sum(axis=1))


def bends(z: Points, ends: Points = ENDS) -> Floats:
    """Return how far the furthest point of each line is from the straight line that fits it best, in pixels."""
    found = []
    for start, end in ends:
        there = places(z, start + (end - start) * np.linspace(0, 1, 60)[:, None])
        there -= there.mean(axis=0)
        found.append(np.abs(there @ np.linalg.svd(there, full_matrices=False)[2][1]).max())
    return np.array(found)


@pytest.mark.parametrize("name", WARPS)
def test_lines_come_out_straighter_and_all_else_holds(name: str) -> None:
    plain = WARPS[name]
    before, found = warped(plain, None), warped(plain, Lines(ENDS))
    assert bends(found.warped).max() < 0.4 * bends(before.warped).max()
    assert not found.folded.any()
    assert max(feature.residual for feature in found.features) < 1e-9
    assert found.outline_moved_px == 0


ACROSS = np.array([[[-0.5, 60.0], [299.5, 64.0]], [[110.0, -0.5], [112.0, 199.5]]])


@pytest.mark.parametrize("cut", [False, True])
def test_where_the_frame_glides_it_does_so_with_lines_that_end_on_it(cut: bool) -> None:
    painted = mask()
    if cut:
        painted[55:120, :30] = painted[:20, 200:260] = 255
    before, found = (warped(WARPS["narrow"], lines, painted) for lines in (None, Lines(ACROSS)))
    assert bends(found.warped, ACROSS).max() < (0.5 if cut else 0.2) * bends(before.warped, ACROSS).max()
    assert found.outline_moved_px == 0
    assert not found.folded.any()
    assert max(feature.residual for feature in found.features) < 1e-9
    sides: list[tuple[Any, int]] = [(np.s_[:, 0], 1), (np.s_[:, -1], 1), (np.s_[0], 0), (np.s_[-1], 0)]
    for side, axis in sides:
        assert np.diff(found.warped[side][:, axis]).min() > 0
        if not cut:
            assert np.array_equal(found.warped[side][:, 1 - axis], before.warped[side][:, 1 - axis])
    glided = [np.abs(found.warped[side] - before.warped[side]).max() for side, _ in sides]
    assert glided[0] > 1 or cut
    assert glided[1] > 1


def test_lines_inside_a_feature_and_no_lines_change_nothing() -> None:
    inside = np.array([[[185.0, 110.0], [215.0, 130.0]]])
    plain = WARPS["twist"]
    before = warped(plain, None).warped
    assert np.array_equal(warped(plain, Lines(np.empty((0, 2, 2)))).warped, before)
    assert np.abs(warped(plain, Lines(inside)).warped - before).max() < 1e-9


def test_without_features_lines_that_w_keeps_straight_stay_where_they_are() -> None:
    none = np.zeros(SIZE[::-1], np.uint8)
    assert np.abs(warped(WARPS["narrow"], Lines(ENDS), none).warped - WARPS["narrow"]).max() < 1e-9
    straightened = warped(WARPS["twist"], Lines(ENDS), none).warped
    assert bends(straightened).max() < 0.4 * bends(WARPS["twist"]).max()


def test_what_is_added_to_the_energy_is_at_its_least() -> None:
    warper = Warper(GRID)
    warper.use(find_features(GRID, mask()), MappingOptions(weight=7.0))
    plain = as_complex(WARPS["twist"])
    ends, levels = np.concatenate([ENDS, [[[60.0, 20.0], [240.0, 90.0]]]]), (True, True, True, False)
    mapping = warper._prepared.mapping  # type: ignore[union-attr]
    solution = mapping.place(plain)
    solver = LineSolver(mapping, Lines(ends), 7.0)
    pull = solver.straighten(solution, plain)
    assert pull is not None
    found = pull.apply(mapping, solution)
    step = 0.02 * float(np.hypot(*SIZE))
    counts = [round(np.linalg.norm(b - a) / step) + 1 for a, b in ends]
    samples = [_sample(count, round(2 * step / min(GRID.cell))) for count in counts]

    def energy(z: Complexes) -> float:
        total = 0.0
        follow = np.where(mapping.owner >= 0, solution.alpha[mapping.owner], 0)
        corners = [np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, 1:], np.s_[1:, :-1]]
        for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
            edge, wanted, arm = (a[end] - a[start] for a in (z, plain, as_complex(GRID.nodes)))
            total += float((mapping.follow_w * np.abs(edge - wanted) ** 2).sum()) / 2
            total += float((mapping.follow_feature * np.abs(edge - follow * arm) ** 2).sum()) / 2
        for (a, b), (places, parts), level in zip(ends, samples, levels, strict=True):
            nodes, weights = GRID.weights_at(a + (b - a) * places.reshape(-1, 1))
            shown = plain if level else found.z
            read = ((values.ravel()[nodes] * weights).sum(axis=1) for values in (z, shown))
            there, chord = ((values.reshape(parts.shape) * parts).sum(axis=1) for values in read)
            share = (places * parts).sum(axis=1)
            across = (np.conj(1j * (chord[-1] - chord[0])) * there).real / abs(chord[-1] - chord[0])
            bend = across - np.polyval(np.polyfit(share, across, 0 if level else 1), share)
            cells = float(np.linalg.norm(b - a)) / 4 / (len(share) - 1)
            total += 7.0 * cells * float((bend**2).sum()) / 2
        return total

    least, rng = energy(found.z), np.random.default_rng(0)
    assert energy(solution.z) > least
    for size in (1e-3, 1e-2, 0.1):
        noise = rng.normal(0, size, GRID.shape) + 1j * rng.normal(0, size, GRID.shape)
        assert energy(found.z + np.where(mapping.free, noise, 0)) > least
    way = solution.z - found.z
    assert energy(found.z + 1e-3 * way) > least < energy(found.z - 1e-3 * way)


def test_what_lies_on_a_line_moves_evenly_and_not_by_steps() -> None:
    before, after = (as_complex(warped(WARPS["arch"], lines).warped) for lines in (None, Lines(ENDS)))
    for a, b in ENDS:
        share = np.linspace(0.1, 0.9, round(0.8 * float(np.linalg.norm(b - a)) / 4))[:, None]
        nodes, weights = GRID.weights_at(a + (b - a) * share)
        moved = ((after - before).ravel()[nodes] * weights).sum(axis=1)
        assert np.abs(np.diff(moved, 2)).max() < 0.2 * np.abs(moved).max()


def test_a_handle_that_is_not_moved_leaves_straight_lines_as_they_are() -> None:
    plain, lines = WARPS["narrow"], Lines(ENDS)
    still = warped(plain, lines)
    at = np.array([[30.0, 100.0], [150.0, 30.0]])
    options = MappingOptions(lines=lines)
    features = find_features(GRID, mask())
    found = warp_grid(GRID, features, plain, options=options, handles=Handles(at, places(still.warped, at)))
    assert np.array_equal(found.warped, still.warped)


def test_while_painting_lines_are_drawn_at_as_before_and_nothing_is_prepared(monkeypatch: pytest.MonkeyPatch) -> None:
    plain, lines, painted = WARPS["narrow"], Lines(ENDS), mask()
    prepared: list[LineSolver] = []
    prepare = LineSolver.__init__

    def count(solver: LineSolver, mapping: FeatureMapping, lines: Lines, weight: float) -> None:
        prepared.append(solver)
        prepare(solver, mapping, lines, weight)

    monkeypatch.setattr(LineSolver, "__init__", count)
    warper, options = Warper(GRID), MappingOptions(lines=lines)

    def frame() -> Warped:
        features = find_features(GRID, painted)
        ready = warper.is_ready(features, options)
        before = len(prepared)
        warper.use(features, options)
        found = warper.frame(plain)
        assert ready == (len(prepared) == before)
        return found

    frame()
    for reach in (24, 27, 30):
        cv2.circle(painted, (100, 100), reach, 255, -1)
        stroke = frame()
    assert len(prepared) == 1
    assert max(feature.residual for feature in stroke.features) < 1e-9
    bare = warped(plain, None, painted).warped
    rest = run(warper.settle(plain)).warped
    assert len(prepared) == 2
    assert np.array_equal(rest, warped(plain, lines, painted).warped)
    assert np.abs(stroke.warped - rest).max() < 0.4 * np.abs(bare - rest).max()
    assert warper.is_ready(stroke.marked, options)
    assert not warper.is_ready(stroke.marked, MappingOptions(lines=Lines(ENDS[:2])))


@pytest.mark.parametrize("place", [(14, 64), (6, 40)])
def test_what_is_painted_onto_a_gliding_frame_beside_a_line_leaves_no_step_there(place: tuple[int, int]) -> None:
    plain, options, painted = WARPS["narrow"], MappingOptions(lines=Lines(ACROSS)), mask()
    warper = Warper(GRID)
    for reach in (0, 6, 10, 14):
        if reach:
            cv2.circle(painted, place, reach, 255, -1)
        warper.use(find_features(GRID, painted), options)
        sketch = warper.frame(plain).warped
        side = sketch[:, 0, 1]
        assert np.diff(side).min() > 0
        assert np.abs(np.diff(side, 2)).max() < 4


NONE = np.zeros(SIZE[::-1], np.uint8)


def kept_by(limits: Limits, plain: Points) -> Points:
    """Return where nodes are when lines have these limits and nothing else is kept."""
    return warped(plain, Lines(ENDS, (limits,) * len(ENDS)), NONE).warped


def chords(z: Points, ends: Points = ENDS) -> Complexes:
    return as_complex(places(z, ends[:, 1]) - places(z, ends[:, 0]))


def test_the_less_a_line_is_protected_the_more_it_bends() -> None:
    plain = WARPS["twist"]
    by = [bends(kept_by(Limits(weight=weight), plain)).max() for weight in (1e-6, 0.25, 0.5, 0.75, 1.0)]
    assert by[0] == pytest.approx(bends(plain).max(), rel=1e-3)
    assert by == sorted(by, reverse=True)
    assert by[2] == pytest.approx((by[0] + by[4]) / 2, rel=0.2)


@pytest.mark.parametrize("aspect", [(0.6, 1.0), (1.0, 1.6)])
def test_a_horizon_that_ends_at_a_feature_stays_level_where_what_is_aslant_may_turn(
    aspect: tuple[float, float],
) -> None:
    plain, horizon = GRID.nodes * aspect, np.array([[[-0.5, 88.0], [52.0, 89.0]], [[-0.5, 125.0], [52.0, 124.0]]])
    aslant = np.array([[[6.0, 70.0], [60.0, 85.0]]])

    def tilts(ends: Points) -> Floats:
        found = warped(plain, Lines(ends)).warped
        return np.abs(np.angle(chords(found, ends) / chords(plain, ends)))

    before = warped(plain, None).warped
    least = np.abs(np.angle(chords(before, horizon) / chords(plain, horizon))).min()
    assert least > 0.1
    assert tilts(horizon).max() < 0.5 * least
    assert tilts(aslant).max() > 0.1


def test_upright_lines_keep_their_angle() -> None:
    plain = make_warp("rise", *SIZE, bend=30)(GRID.nodes)
    before = np.angle(as_complex(ENDS[:, 1] - ENDS[:, 0]))
    free, upright = (chords(kept_by(limits, plain)) for limits in (FREE, Limits(turns=False)))
    tilted, kept = (np.abs(np.angle(found * np.exp(-1j * before))) for found in (free, upright))
    assert tilted.max() > 0.05
    assert kept.max() < 0.4 * tilted.max()


@pytest.mark.parametrize(("plain", "limits"), [("narrow", Limits(least=0.85)), ("wide", Limits(most=1.2))])
def test_lengths_of_lines_come_nearer_to_their_bounds_and_those_within_stay(plain: str, limits: Limits) -> None:
    lengths = np.abs(as_complex(ENDS[:, 1] - ENDS[:, 0]))
    before, after = (np.abs(chords(kept_by(limit, WARPS[plain]))) / lengths for limit in (FREE, limits))
    bound = limits.least or limits.most
    assert np.abs(after - bound)[2] < 0.6 * np.abs(before - bound)[2]
    assert after[1] == pytest.approx(before[1], abs=0.03)
    assert np.array_equal(kept_by(Limits(least=0.1, most=9.0), WARPS[plain]), kept_by(FREE, WARPS[plain]))
