"""Features one by one: what each may do, under warps that bend, turn and fold, and under pins."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.arrays import Bytes, InputError, Points
from core.grid import Grid, find_features
from core.mapping.features.feature_mapping import FeatureMapping, Method
from core.mapping.features.limits import FREE, RIGID, Limits
from core.mapping.handles.handles import Handles
from core.mapping.handles.plate import Frame
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.options import MappingOptions
from core.mapping.result import FeatureReport, Warped
from core.mapping.warping import warp_grid
from core.warps.presets import make_warp

SIZE = 300, 200
GRID = Grid(*SIZE, cell_px=4)
UPRIGHT, LIMITED = Limits(1.0, 1.0, turns=False), Limits(0.8, 0.9)


def mask() -> Bytes:
    found = np.zeros(SIZE[::-1], np.uint8)
    cv2.circle(found, (70, 70), 32, 255, -1)
    cv2.circle(found, (150, 130), 30, 255, -1)
    found[60:120, 215:265] = 255
    return found


FEATURES = find_features(GRID, mask())
FIRST, THIRD, SECOND = FEATURES.ids.tolist()
PRESETS = [("arc", 45), ("flag", 60), ("swirl", 60), ("twist", 80), ("inflate", 50)]


def bent(preset: str, bend: float) -> Points:
    return make_warp(preset, *SIZE, bend=bend)(GRID.nodes)


def warped(
    plain: Points,
    single: dict[int, Limits],
    handles: Handles | None = None,
    frame: Frame = "held",
    *,
    painted: Bytes | None = None,
) -> Warped:
    options = MappingOptions(single=tuple(sorted(single.items())), frame=frame)
    return warp_grid(
        GRID, find_features(GRID, mask() if painted is None else painted), plain, options=options, handles=handles
    )


def of(found: Warped, number: int) -> FeatureReport:
    return next(feature for feature in found.features if feature.id == number)


@pytest.mark.parametrize(("preset", "bend"), PRESETS)
def test_each_feature_keeps_what_it_is_to_keep(preset: str, bend: float) -> None:
    plain = bent(preset, bend)
    free, found = warped(plain, {}), warped(plain, {FIRST: UPRIGHT, SECOND: LIMITED})
    assert not found.folded.any()
    assert max(feature.residual for feature in found.features) < 1e-9
    assert of(found, FIRST).scale == pytest.approx(1, abs=1e-9)
    assert of(found, FIRST).angle_deg == pytest.approx(0, abs=1e-9)
    assert of(found, SECOND).scale == pytest.approx(np.clip(of(free, SECOND).scale, 0.8, 0.9), abs=1e-9)
    assert of(found, THIRD).scale == pytest.approx(of(free, THIRD).scale, rel=0.02)


def test_features_without_limits_do_turn_and_shrink_there() -> None:
    found = [warped(bent(preset, bend), {}) for preset, bend in PRESETS]
    assert max(abs(of(warp, FIRST).angle_deg) for warp in found) > 10
    assert min(of(warp, FIRST).scale for warp in found) < 0.8
    assert min(of(warp, SECOND).scale for warp in found) < 0.8


@pytest.mark.parametrize("method", ["exact", "per-quad"])
def test_all_rigid_one_by_one_is_rigid(method: Method) -> None:
    plain = bent("twist", 80)
    single = tuple((number, RIGID) for number in (FIRST, SECOND, THIRD))
    found = [
        warp_grid(GRID, FEATURES, plain, options=options).warped
        for options in (
            MappingOptions(keep="rigid", method=method),
            MappingOptions(single=single, method=method),
            MappingOptions(single=((FIRST, FREE),), method=method),
            MappingOptions(method=method),
        )
    ]
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[2], found[3])
    assert np.abs(found[0] - found[2]).max() > 5


@settings(max_examples=15)
@given(st.floats(0.3, 3), st.floats(-3, 3))
def test_under_a_similarity_only_limits_keep_features_from_it(scale: float, angle: float) -> None:
    mapping = FeatureMapping(GRID, FEATURES, single={FIRST: Limits(turns=False), SECOND: LIMITED})
    found = mapping.place(as_complex(GRID.nodes) * scale * np.exp(1j * angle))
    alpha = {body.number: complex(a) for body, a in zip(mapping.bodies, found.alpha, strict=True)}
    assert alpha[FIRST] == pytest.approx(scale, abs=1e-9)
    assert abs(alpha[SECOND]) == pytest.approx(np.clip(scale, 0.8, 0.9), abs=1e-9)
    assert abs(alpha[THIRD]) == pytest.approx(scale, abs=1e-9)


def test_the_reduced_system_minimises_the_energy_within_limits() -> None:
    mapping, w = FeatureMapping(GRID, FEATURES, single={FIRST: UPRIGHT, SECOND: LIMITED}), as_complex(bent("twist", 60))
    solution = mapping.place(w)
    rest, rng = as_complex(GRID.nodes), np.random.default_rng(0)

    def energy(alpha: Complexes, t: Complexes) -> float:
        z = mapping.place_at(w, alpha, t).z
        follow = np.where(mapping.owner >= 0, alpha[mapping.owner], 0)
        corners = [np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, 1:], np.s_[1:, :-1]]
        total = 0.0
        for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
            edge, wanted, arm = (a[end] - a[start] for a in (z, w, rest))
            total += float((mapping.follow_w * np.abs(edge - wanted) ** 2).sum())
            total += float((mapping.follow_feature * np.abs(edge - follow * arm) ** 2).sum())
        return total

    turns = np.array([body.number != FIRST for body in mapping.bodies])
    least = energy(solution.alpha, solution.t)
    for _ in range(10):
        alpha = solution.alpha * np.exp(1j * np.where(turns, rng.normal(0, 1e-2, 3), 0))
        assert energy(alpha, solution.t + rng.normal(0, 0.1, 3) + 1j * rng.normal(0, 0.1, 3)) > least


@pytest.mark.parametrize("frame", ["held", "free"])
@pytest.mark.parametrize("preset", ["none", "arch"])
def test_pins_neither_turn_nor_grow_what_may_not(frame: Frame, preset: str) -> None:
    single = {FIRST: Limits(turns=False), SECOND: Limits(0.5, 1.1)}
    at = np.array([[55.0, 70.0], [85.0, 70.0], [135.0, 130.0], [165.0, 130.0], [240.0, 90.0], [110.0, 60.0]])
    to = np.array([[58.0, 60.0], [88.0, 92.0], [115.0, 130.0], [190.0, 130.0], [240.0, 100.0], [112.0, 66.0]])
    found, free = (warped(bent(preset, 20), limits, Handles(at, to), frame) for limits in (single, {}))
    assert abs(of(free, FIRST).angle_deg) > 10
    assert of(free, SECOND).scale > 1.3
    assert not found.folded.any()
    assert max(feature.residual for feature in found.features) < 1e-9
    assert of(found, FIRST).angle_deg == pytest.approx(0, abs=1e-6)
    assert of(found, SECOND).scale == pytest.approx(1.1, abs=1e-6)
    assert found.pin_reports[-1].error_px < 1e-3
    assert found.pin_reports[-2].error_px < 1e-3


@pytest.mark.parametrize("frame", ["held", "free"])
def test_one_pin_moves_an_upright_feature_without_turning_it_and_its_neighbour_neither(frame: Frame) -> None:
    single = {FIRST: Limits(turns=False), SECOND: Limits(turns=False)}
    handles = Handles(np.array([[45.0, 80.0], [120.0, 40.0]]), np.array([[60.0, 110.0], [140.0, 20.0]]))
    found, free = (warped(GRID.nodes, limits, handles, frame) for limits in (single, {}))
    for number in (FIRST, SECOND):
        assert abs(of(free, number).angle_deg) > 0.01
        assert of(found, number).angle_deg == pytest.approx(0, abs=1e-6)
    assert not found.missed_pins


@pytest.mark.parametrize("turns", [True, False])
def test_of_many_features_the_small_ones_stay_upright_too(turns: bool) -> None:
    painted = np.zeros(SIZE[::-1], np.uint8)
    for number in range(40):
        cv2.circle(painted, (25 + 36 * (number % 8), 20 + 40 * (number // 8)), 8 + number % 5, 255, -1)
    single = dict.fromkeys(find_features(GRID, painted).ids.tolist(), Limits(turns=turns))
    handles = Handles(np.array([[100.0, 90.0], [200.0, 110.0]]), np.array([[112.0, 70.0], [190.0, 135.0]]))
    found = warped(bent("swirl", 20), single, handles, painted=painted)
    assert len(found.features) == 40
    assert not found.folded.any()
    least = sorted(abs(feature.angle_deg) for feature in found.features)
    assert least[-1] > 5 if turns else least[-1] < 1e-6


@pytest.mark.parametrize(("preset", "bend"), [("arc", 60), ("inflate", 80), ("swirl", 50)])
def test_what_the_frame_cuts_stays_upright_too(preset: str, bend: float) -> None:
    painted = mask()
    painted[80:130, :30] = painted[170:, 180:230] = 255
    numbers = find_features(GRID, painted).ids.tolist()
    single = dict.fromkeys(numbers, Limits(turns=False))
    found = warped(bent(preset, bend), single, painted=painted)
    assert not found.folded.any()
    assert max(feature.residual for feature in found.features) < 1e-9
    assert max(abs(feature.angle_deg) for feature in found.features) < 1e-6


@pytest.mark.parametrize("bounds", [(1.2, 0.8), (-0.1, 1.0), (0.0, 0.0), (float("nan"), 1.0), (float("inf"),) * 2])
def test_bounds_that_nothing_lies_between_are_refused(bounds: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="size of a feature"):
        Limits(*bounds)
