"""What pins and inner curves do to a picture with features: the axioms, and the frame."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.arrays import Bytes, InputError, Points
from core.curves.bezier import Curve
from core.grid import Grid, find_features
from core.mapping.folds import find_folded_quads
from core.mapping.handles.handles import Handles
from core.mapping.handles.plate import Frame
from core.mapping.jacobians import as_complex, as_positions
from core.mapping.options import Keep, MappingOptions
from core.mapping.result import FeatureReport, Warped
from core.mapping.warper import Warper
from core.mapping.warping import warp_grid, warp_job
from core.progress import Steps
from core.warps.presets import make_warp

SIZE = 242, 182
"""Of which no node lies half-way between two pixels, which a mirrored mask would have on the other side."""
GRID = Grid(*SIZE, cell_px=4)
PLACES = np.array([[30.2, 40.7], [200.0, 30.0], [120.5, 150.3], [121.9, 90.1]])
IN_ONE = np.array([[60.0, 110.0], [80.0, 95.0]])
NONE = np.empty((0, 2))
FRAMES: list[Frame] = ["held", "free"]


def mask(size: tuple[int, int] = SIZE) -> Bytes:
    found = np.zeros(size[::-1], np.uint8)
    cv2.circle(found, (70, 100), 26, 255, -1)
    cv2.circle(found, (170, 80), 22, 255, -1)
    return found


def moved(
    handles: Handles,
    *,
    painted: Bytes | None = None,
    base: Points | None = None,
    frame: Frame = "held",
    keep: Keep = "similarity",
    grid: Grid = GRID,
) -> Warped:
    features = find_features(grid, painted)
    options = MappingOptions(keep=keep if painted is not None else "none", frame=frame)
    return warp_grid(grid, features, grid.nodes if base is None else base, options=options, handles=handles)


def places(found: Warped, at: Points, grid: Grid = GRID) -> Points:
    nodes, weights = grid.weights_at(at)
    return np.asarray((found.warped.reshape(-1, 2)[nodes] * weights[..., None]).sum(axis=1))


def residuals(found: Warped) -> list[float]:
    return [feature.residual for feature in found.features]


def turned(found: Warped) -> FeatureReport:
    return max(found.features, key=lambda feature: abs(feature.angle_deg))


@pytest.mark.parametrize("keep", ["similarity", "rigid", "none"])
@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("preset", ["none", "arch"])
def test_pins_are_met_and_features_are_exact(frame: Frame, keep: Keep, preset: str) -> None:
    base = make_warp(preset, *SIZE, bend=30)(GRID.nodes)
    at = np.concatenate([PLACES, IN_ONE[:1]])
    shift = np.array([[5.0, 3], [-4, 6], [2, -7], [-6, -2], [4, 5]])
    there = places(moved(Handles(NONE, NONE), painted=mask(), base=base, keep=keep), at)
    found = moved(Handles(at, there + shift), painted=mask(), base=base, frame=frame, keep=keep)
    assert np.abs(places(found, at) - there - shift).max() < 1e-3
    assert [pin.error_px < 1e-3 for pin in found.pin_reports] == [True] * 5
    assert not found.folded.any()
    if keep != "none":
        assert max(residuals(found)) < 1e-9


@pytest.mark.parametrize("preset", ["none", "arch", "swirl"])
def test_a_pin_set_where_it_is_changes_no_bit(preset: str) -> None:
    base = make_warp(preset, *SIZE, bend=40)(GRID.nodes)
    without = moved(Handles(NONE, NONE), painted=mask(), base=base)
    at = np.concatenate([PLACES, IN_ONE, [[-0.5, 60.0], [1.0, 1.0]]])
    found = moved(Handles(at, places(without, at)), painted=mask(), base=base)
    assert np.array_equal(found.warped, without.warped)
    assert np.array_equal(found.plain, without.plain)


def test_a_pin_set_beside_others_that_were_dragged_moves_nothing_that_shows() -> None:
    at = np.concatenate([PLACES, IN_ONE[:1]])
    to = at + [[9, 5], [-4, 6], [2, -7], [-6, -2], [4, 5]]
    without = moved(Handles(at, to), painted=mask())
    more = np.array([[95.0, 40.0], [140.0, 120.0], [220.0, 160.0]])
    found = moved(Handles(np.concatenate([at, more]), np.concatenate([to, places(without, more)])), painted=mask())
    assert np.abs(found.warped - without.warped).max() < 0.02


@pytest.mark.parametrize("far", [1, 6])
def test_the_order_of_handles_changes_no_bit(far: int) -> None:
    at = np.concatenate([PLACES, IN_ONE])
    to = at + far * np.array([[5, 3], [-4, 6], [2, -7], [-6, -2], [4, 5], [3, 9]])
    order = [4, 2, 0, 5, 3, 1]
    one, other = (moved(Handles(at[k], to[k]), painted=mask()) for k in (range(6), order))
    assert np.array_equal(one.warped, other.warped)


def test_a_mirrored_picture_has_the_mirrored_map() -> None:
    at = np.concatenate([PLACES, IN_ONE])
    to = at + [[5, 3], [-4, 6], [2, -7], [-6, -2], [4, 5], [3, 9]]
    turn = np.array([-1.0, 1.0])
    shift = np.array([SIZE[0] - 1.0, 0.0])
    one = moved(Handles(at, to), painted=mask())
    other = moved(Handles(at * turn + shift, to * turn + shift), painted=np.ascontiguousarray(mask()[:, ::-1]))
    assert np.abs(other.warped[:, ::-1] * turn + shift - one.warped).max() < 1e-3


def test_a_picture_turned_by_a_right_angle_has_the_turned_map() -> None:
    at = np.concatenate([PLACES, IN_ONE])
    to = at + [[5, 3], [-4, 6], [2, -7], [-6, -2], [4, 5], [3, 9]]
    upright = np.ascontiguousarray(np.rot90(mask()))
    grid = Grid(*SIZE[::-1], cell_px=4)

    def turn(points: Points) -> Points:
        return np.stack([points[..., 1], SIZE[0] - 1 - points[..., 0]], axis=-1)

    one = moved(Handles(at, to), painted=mask())
    other = moved(Handles(turn(at), turn(to)), painted=upright, grid=grid)
    assert np.abs(np.rot90(turn(one.warped)) - other.warped).max() < 1e-3


def near_features() -> Bytes:
    """Return two features, of which the grid's coarse cells lie as near to one as to the other."""
    found = np.zeros(SIZE[::-1], np.uint8)
    found[60:130, 50:106] = found[50:100, 130:200] = 255
    return found


def bent_feature() -> Bytes:
    found = np.zeros(SIZE[::-1], np.uint8)
    found[40:130, 50:75] = found[110:130, 50:200] = found[40:130, 170:190] = 255
    return found


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(
    ("painted", "preset", "bend", "keep"),
    [
        (bent_feature(), "swirl", 90, "similarity"),
        (bent_feature(), "squeeze", 90, "rigid"),
        (near_features(), "swirl", 90, "similarity"),
        (near_features(), "squeeze", 90, "rigid"),
        (near_features(), "arc", 90, "rigid"),
    ],
)
def test_what_would_fold_is_mirrored_with_the_picture(
    painted: Bytes, preset: str, bend: float, keep: Keep, axis: int
) -> None:
    base = make_warp(preset, *SIZE, bend=bend)(GRID.nodes)
    live = Warper(GRID)
    live.use(find_features(GRID, painted), MappingOptions(keep=keep))
    assert live.frame(base).folded.any()
    one = moved(Handles(NONE, NONE), painted=painted, base=base, keep=keep)
    other = moved(
        Handles(NONE, NONE), painted=np.flip(painted, axis).copy(), base=mirrored(np.flip(base, axis), axis), keep=keep
    )
    assert not one.folded.any()
    assert np.abs(mirrored(np.flip(other.warped, axis), axis) - one.warped).max() < 1e-3


def mirrored(points: Points, axis: int) -> Points:
    """Return points (..., 2) of the picture where they are once it is mirrored: 1 left and right, 0 top and bottom."""
    turn = np.array([-1.0, 1.0] if axis == 1 else [1.0, -1.0])
    return np.ascontiguousarray(points * turn + np.where(turn < 0, np.subtract(SIZE, 1.0), 0.0))


@pytest.mark.parametrize("seed", [1, 4])
def test_pins_that_cannot_all_be_held_are_mirrored_with_the_picture(seed: int) -> None:
    random = np.random.default_rng(seed)
    at = random.uniform(0.1, 0.9, (3, 2)) * SIZE
    to = at + random.normal(0, 30, at.shape)
    one = moved(Handles(at, to), painted=near_features(), keep="rigid")
    other = moved(
        Handles(mirrored(at, 1), mirrored(to, 1)), painted=np.ascontiguousarray(near_features()[:, ::-1]), keep="rigid"
    )
    assert not one.folded.any()
    assert np.abs(mirrored(np.flip(other.warped, 1), 1) - one.warped).max() < 1e-3


def test_one_pin_in_a_feature_moves_it_and_keeps_its_size() -> None:
    pin = IN_ONE[:1]
    found = moved(Handles(pin, pin + [9, -4]), painted=mask())
    assert np.abs(places(found, pin) - pin - [9, -4]).max() < 1e-6
    assert turned(found).scale == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize(("keep", "scale"), [("similarity", 0.9), ("rigid", 1.0)])
def test_two_pins_in_a_feature_turn_it_and_a_rigid_one_keeps_its_size(keep: Keep, scale: float) -> None:
    middle, alpha = IN_ONE.mean(axis=0), 0.9 * np.exp(1j * np.radians(27))
    to = as_positions(as_complex(IN_ONE - middle) * alpha) + middle
    found = moved(Handles(IN_ONE, to), painted=mask(), keep=keep)
    assert turned(found).angle_deg == pytest.approx(27, abs=1e-6)
    assert turned(found).scale == pytest.approx(scale, abs=1e-9)
    missed = [pin.error_px for pin in found.pin_reports]
    assert max(missed) == pytest.approx(0 if keep == "similarity" else 0.05 * np.hypot(20, 15), abs=1e-6)


def test_a_feature_turned_far_shears_nothing_beside_it() -> None:
    middle = np.array([70.0, 100.0])
    at = middle + [[-15.0, 0], [15, 0]]
    to = as_positions(as_complex(at - middle) * np.exp(1j * np.radians(45))) + middle
    live = Warper(GRID)
    live.use(find_features(GRID, mask()), MappingOptions())
    found = live.frame(GRID.nodes, Handles(at, to))
    assert turned(found).angle_deg == pytest.approx(45, abs=1e-6)
    assert not found.folded.any()


def test_points_of_a_curve_across_a_feature_are_met_outside_it_and_fitted_inside() -> None:
    source = Curve(np.array([[20.0, 100], [60, 90], [120, 120], [220, 150]]))
    target = Curve(source.points + [[0.0, 8], [0, 8], [0, 8], [0, 4]])
    found = moved(Handles(NONE, NONE, [(source, target)]), painted=mask())
    t = np.linspace(0, 1, 200)
    outside = np.hypot(*(source.at(t) - [70, 100]).T) > 34
    assert np.hypot(*(places(found, source.at(t)) - target.at(t)).T)[outside].max() < 0.3
    assert max(residuals(found)) < 1e-9
    assert not found.folded.any()


def test_how_far_a_curve_is_from_its_target_is_said() -> None:
    source = Curve(np.array([[20.0, 100], [60, 90], [120, 120], [220, 150]]))
    bent = Curve(source.points + [[0.0, 0], [0, 60], [0, -60], [0, 0]])
    missed, held = (moved(Handles(NONE, NONE, [(source, to)]), painted=mask()) for to in (bent, source))
    assert not missed.folded.any()
    t = source.parameter_at(np.linspace(0, source.length, 300))
    off = np.hypot(*(places(missed, source.at(t)) - bent.at(t)).T).max()
    assert missed.curves_off_px == pytest.approx(off, abs=1)
    said = f"inner curves are up to {missed.curves_off_px:.1f} px from where they were dragged"
    assert [line.startswith(said) for line in missed.complaints()] == [True]
    assert held.complaints() == []


def test_a_target_beyond_all_pictures_is_said_in_few_digits() -> None:
    found = moved(Handles(PLACES[:1], PLACES[:1] + [1e300, 0.0]), painted=mask())
    assert not found.folded.any()
    assert [len(line) < 120 and "1.0e+300 px" in line for line in found.complaints()] == [True]


def test_a_target_far_outside_a_held_frame_is_missed_and_nothing_folds() -> None:
    pins = np.array([[120.0, 90.0], [30.0, 30.0]])
    found = moved(Handles(pins, pins + [[1e6, 0.0], [0.0, 0.0]]), painted=mask())
    assert not found.folded.any()
    assert max(residuals(found)) < 1e-9
    assert found.pin_reports[0].error_px > 9e5


def test_no_handles_are_the_identity() -> None:
    assert np.array_equal(moved(Handles(PLACES, PLACES)).warped, GRID.nodes)


@settings(max_examples=15, deadline=None)
@given(st.floats(0.5, 2), st.floats(-3, 3), st.floats(-50, 50), st.integers(2, 4))
def test_pins_that_agree_with_a_similarity_give_it_to_a_free_picture(
    scale: float, angle: float, shift: float, count: int
) -> None:
    alpha, t = scale * np.exp(1j * angle), shift * (1 + 0.3j)
    wanted = as_positions(as_complex(GRID.nodes) * alpha + t)
    to = as_positions(as_complex(PLACES[:count]) * alpha + t)
    assert np.abs(moved(Handles(PLACES[:count], to), frame="free").warped - wanted).max() < 1e-5


def test_one_pin_on_a_free_picture_moves_it_whole() -> None:
    for painted in (None, mask()):
        found = moved(Handles(PLACES[:1], PLACES[:1] + [7, -4]), frame="free", painted=painted)
        assert np.abs(found.warped - GRID.nodes - [7, -4]).max() < 1e-5


def test_the_held_frame_stays_where_the_base_has_it() -> None:
    base = make_warp("arch", *SIZE, bend=40)(GRID.nodes)
    found = moved(Handles(PLACES, PLACES + 9), base=base)
    assert np.array_equal(found.warped[GRID.outline], base[GRID.outline])


def test_two_pins_on_one_spot_go_to_the_middle_of_their_targets() -> None:
    twice = PLACES[[0, 0, 1]]
    found = moved(Handles(twice, twice + [[4, 0], [0, 8], [0, 0]]))
    assert np.abs(places(found, PLACES[:1]) - PLACES[:1] - [2, 4]).max() < 1e-6
    assert [pin.error_px for pin in found.pin_reports[:2]] == pytest.approx([np.hypot(2, 4)] * 2, abs=1e-6)


def test_handles_that_do_not_pair_up_are_refused() -> None:
    with pytest.raises(InputError, match="2 places"):
        Handles(PLACES[:2], PLACES[:1])
    line = np.array([[0.0, 0], [1, 1], [2, 2], [3, 3]])
    twice = np.concatenate([line, line[1:] + 3])
    with pytest.raises(InputError, match=r"curves\[0\]"):
        Handles(PLACES[:0], PLACES[:0], [(Curve(line), Curve(twice))])


@pytest.mark.parametrize("size", [(1, 1), (1, 50), (2, 2), (3, 3)])
def test_tiny_pictures_take_pins(size: tuple[int, int]) -> None:
    grid = Grid(*size)
    for frame in FRAMES:
        for painted in (None, np.full(size[::-1], 255, np.uint8)):
            pin = np.zeros((1, 2))
            found = moved(Handles(pin, pin + 0.1), frame=frame, painted=painted, grid=grid)
            assert np.isfinite(found.warped).all()


HARD = Grid(240, 180, cell_px=4)


@pytest.mark.parametrize("keep", ["similarity", "rigid"])
def test_a_pin_that_cannot_cross_two_features_comes_part_of_the_way(keep: Keep) -> None:
    pin = np.array([[8.0, 90.0]])
    found = moved(Handles(pin, pin + [217.0, 0.0]), painted=mask((240, 180)), keep=keep, grid=HARD)
    assert not found.folded.any()
    assert max(residuals(found)) < 1e-9
    assert 1 < found.pin_reports[0].error_px < 0.6 * 217


def test_what_is_shown_of_a_pin_that_cannot_be_met_does_not_fold_and_what_stays_is_nearer() -> None:
    pin = np.array([[8.0, 90.0]])
    to = pin + [217.0, 0.0]
    steps = Steps(warp_job(HARD, find_features(HARD, mask((240, 180))), HARD.nodes, handles=Handles(pin, to)))
    shown = [step.preview for step in steps if step.preview is not None]
    assert shown
    assert not any(find_folded_quads(as_complex(z)).any() for z in shown)
    missed = [np.hypot(*(places(replace(steps.result, warped=z), pin, HARD) - to)[0]) for z in shown]
    assert steps.result.pin_reports[0].error_px < 0.5 * min(missed)


def test_under_a_free_frame_far_pins_are_met_without_a_fold() -> None:
    at = np.concatenate([PLACES, IN_ONE])
    handles = Handles(at, at + 8 * np.array([[5, 3], [-4, 6], [2, -7], [-6, -2], [4, 5], [3, 9]]))
    live = Warper(GRID)
    live.use(find_features(GRID, mask()), MappingOptions(frame="free"))
    assert live.frame(GRID.nodes, handles).folded.any()
    found = moved(handles, painted=mask(), frame="free")
    assert not found.folded.any()
    assert max(residuals(found)) < 1e-9
    assert max(pin.error_px for pin in found.pin_reports) < 0.1


def test_pins_yield_before_the_size_of_a_rigid_feature() -> None:
    at = np.array([[40.0, 100.0], [100.0, 100.0], [70.0, 135.0]])
    to = np.array([70.0, 100.0]) + 0.2 * (at - [70.0, 100.0])
    found = moved(Handles(at, to), painted=mask((240, 180)), keep="rigid", grid=HARD)
    assert not found.folded.any()
    assert [feature.scale for feature in found.features] == pytest.approx([1, 1], abs=1e-9)
    assert len(found.missed_pins) == 3
