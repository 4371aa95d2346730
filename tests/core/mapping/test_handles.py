"""What pins and inner curves do to a picture with features: the axioms, and the frame."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.arrays import Bytes, InputError, Points
from core.curves.bezier import Curve
from core.grid import Grid, find_features
from core.mapping.features.similarity import fit_residual
from core.mapping.handles.dirichlet_plate import HeldPlate
from core.mapping.handles.handles import Handles
from core.mapping.handles.plate import Frame, HandleField
from core.mapping.jacobians import Complexes, as_complex, as_positions
from core.mapping.options import Keep, MappingOptions
from core.mapping.result import FeatureReport, Warped
from core.mapping.warper import Warper
from core.mapping.warping import warp_grid
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


def test_the_order_of_handles_changes_no_bit() -> None:
    at = np.concatenate([PLACES, IN_ONE])
    to = at + [[5, 3], [-4, 6], [2, -7], [-6, -2], [4, 5], [3, 9]]
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


@pytest.mark.parametrize("keep", ["similarity", "rigid"])
@pytest.mark.parametrize("stretch", [(1.5, 1.0), (0.7, 1.0), (1.0, 1.6), (1.3, 0.8)])
def test_a_new_size_fills_its_rectangle_and_features_at_the_frame_slide(
    stretch: tuple[float, float], keep: Keep
) -> None:
    painted = mask()
    cv2.circle(painted, (120, 10), 25, 255, -1)
    cv2.rectangle(painted, (220, 120), (239, 150), 255, -1)
    base = (GRID.nodes + 0.5) * stretch - 0.5
    found = moved(Handles(NONE, NONE), painted=painted, base=base, keep=keep)
    z = found.warped
    sides = z[:, 0, 0], z[0, :, 1], z[:, -1, 0], z[-1, :, 1]
    there = -0.5, -0.5, SIZE[0] * stretch[0] - 0.5, SIZE[1] * stretch[1] - 0.5
    for side, place in zip(sides, there, strict=True):
        assert np.abs(side - place).max() < 1e-9
    assert not found.folded.any()
    assert max(residuals(found)) < 1e-9
    assert [feature.angle_deg for feature in found.features if feature.nodes < 200] == pytest.approx(
        [0, 0, 0, 0], abs=40
    )
    assert found.outline_moved_px == 0


def test_a_band_across_the_picture_has_the_size_of_the_new_width() -> None:
    painted = np.zeros(SIZE[::-1], np.uint8)
    painted[80:120] = 255
    found = moved(Handles(NONE, NONE), painted=painted, base=(GRID.nodes + 0.5) * [1.4, 1.0] - 0.5)
    assert found.features[0].scale == pytest.approx(1.4, abs=1e-9)
    assert found.features[0].angle_deg == pytest.approx(0, abs=1e-9)
    assert not found.folded.any()


def test_a_feature_from_side_to_side_that_is_too_tall_at_its_new_size_covers_the_canvas() -> None:
    painted = np.zeros(SIZE[::-1], np.uint8)
    painted[20:170] = 255
    found = moved(Handles(NONE, NONE), painted=painted, base=(GRID.nodes + 0.5) * [1.5, 1.0] - 0.5)
    low, high = found.warped.reshape(-1, 2).min(axis=0), found.warped.reshape(-1, 2).max(axis=0)
    assert (low <= -0.5 + 1e-9).all()
    assert (high >= np.array(SIZE) * [1.5, 1.0] - 0.5 - 1e-9).all()
    assert max(residuals(found)) < 1e-12
    assert not found.folded.any()
    assert found.outline_moved_px > 1


def test_a_rigid_feature_at_one_side_is_no_larger_than_the_new_width() -> None:
    painted = np.zeros(SIZE[::-1], np.uint8)
    painted[60:120, :200] = 255
    found = moved(Handles(NONE, NONE), painted=painted, base=(GRID.nodes + 0.5) * [0.6, 1.0] - 0.5, keep="rigid")
    assert 0.6 < found.features[0].scale < 0.75
    assert fit(found) < 1e-9
    assert not found.folded.any()
    assert found.outline_moved_px == 0


def fit(found: Warped) -> float:
    """Return the residual of the largest feature from its best-fit similarity."""
    inside = found.marked.labels == found.features[0].id
    return fit_residual(as_complex(found.rest)[inside], as_complex(found.warped)[inside], rigid=False)


def test_a_pin_on_a_straight_frame_slides_along_it() -> None:
    pin = np.array([[120.0, -0.5]])
    found = moved(Handles(pin, pin + [12.0, 7.0]))
    assert places(found, pin)[0] == pytest.approx([132, -0.5], abs=0.6)
    assert found.pin_reports[0].error_px == pytest.approx(7, abs=0.6)
    assert np.array_equal(found.warped[0, :, 1], GRID.nodes[0, :, 1])


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


@pytest.mark.parametrize("size", [(120, 90), (24, 300), (90, 9), (9, 9), (6, 200)])
def test_a_held_plate_bends_as_little_as_the_handles_allow(size: tuple[int, int]) -> None:
    """The plate's answer has the gradient of E at nodes that no handle holds, within the outline: zero."""
    grid = Grid(*size, cell_px=3)
    at = np.array([[0.4, 0.5], [0.7, 0.3], [0.71, 0.33]]) * size
    field = HandleField(grid)
    field.hold(at, spare=0)
    d = field.displace(as_complex(np.array([[4.0, 1.0], [-2.0, 3.0], [-2.5, 3.0]])))
    unit = np.sqrt(np.prod(grid.cell))
    width, height = grid.cell / unit

    def sides(z: Complexes) -> Complexes:
        padded = np.pad(z, 1)
        x = (2 * z - padded[1:-1, :-2] - padded[1:-1, 2:]) / width**2
        return np.asarray(x + (2 * z - padded[:-2, 1:-1] - padded[2:, 1:-1]) / height**2)

    inner = d[1:-1, 1:-1]
    length = 0.1 * np.hypot(*grid.shape)
    forces = np.zeros(grid.shape, np.complex128)
    forces[1:-1, 1:-1] = sides(inner) + length**2 * sides(sides(inner))
    at_handles = np.zeros(grid.size, bool)
    margin = np.minimum(grid.cell, np.array(size) / 2)
    at_handles[grid.weights_at(np.clip(at, margin - 0.5, size - margin - 0.5))[0]] = True
    loose = ~at_handles.reshape(grid.shape)
    assert np.abs(forces).max() > 0.01
    assert np.abs(forces[loose]).max() < 1e-9 * np.abs(forces).max()


def test_an_unknown_motion_of_the_plate_leaves_no_force_on_a_body() -> None:
    field, grid = HandleField(GRID), GRID
    rim = np.array([[150.0, 80.0], [190, 80], [170, 60], [170, 100]])
    at = np.concatenate([[[60.0, 60.0]], rim])
    Q = np.zeros((5, 3), np.complex128)
    Q[1:, 0], Q[1:, 1], Q[1:, 2] = 1j * as_complex(rim - rim.mean(axis=0)), 1, 1j
    field.hold(at, spare=0)
    known = np.array([20.0 + 5j, 0, 0, 0, 0])
    found = known + Q @ field.find_motions(known, Q)
    d = field.displace(found)
    assert np.abs(field.at_points(d) - found).max() < 1e-9
    assert fit_residual(as_complex(rim), as_complex(rim) + field.at_points(d)[1:], rigid=False) < 1e-12
    assert abs(found[1:].mean()) > 0.1
    assert grid.shape == d.shape


def test_responses_are_what_the_answers_have_at_the_places() -> None:
    grid = Grid(300, 170, cell_px=7)
    at = np.random.default_rng(3).uniform(8, 160, (9, 2))
    plate = HeldPlate(grid, cell=(1.02, 0.98), rounded=5.0)
    plate.hold(at[[2, 5]])
    S = plate.hold(at)
    nodes, weights = grid.weights_at(at)
    for force, row in zip(np.eye(9, dtype=np.complex128), S, strict=True):
        assert np.abs((plate.answer(force)[nodes] * weights).sum(axis=1) - row).max() < 1e-12 * S.max()


def test_the_fast_poisson_solve_has_its_load() -> None:
    plate = HeldPlate(GRID, cell=(1.0, 1.0), rounded=5.0)
    load = np.zeros(GRID.shape, np.complex128)
    load[20, 13], load[5, 40] = 1 + 2j, -3j
    y = plate.solve_poisson(load)
    padded = np.pad(y, 1)
    inner = 2 * (4 * y - padded[1:-1, :-2] - padded[1:-1, 2:] - padded[:-2, 1:-1] - padded[2:, 1:-1])
    assert np.abs(y[GRID.outline]).max() == 0
    assert np.abs((inner - load)[1:-1, 1:-1]).max() < 1e-12


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


def test_pins_yield_before_the_size_of_a_rigid_feature() -> None:
    at = np.array([[40.0, 100.0], [100.0, 100.0], [70.0, 135.0]])
    to = np.array([70.0, 100.0]) + 0.2 * (at - [70.0, 100.0])
    found = moved(Handles(at, to), painted=mask((240, 180)), keep="rigid", grid=HARD)
    assert not found.folded.any()
    assert [feature.scale for feature in found.features] == pytest.approx([1, 1], abs=1e-9)
    assert len(found.missed_pins) == 3
