"""Rings on pins: how far the picture is turned and scaled around a point."""

from typing import Any

import cv2
import numpy as np
import pytest

from core.arrays import Bytes, InputError, Points
from core.grid import Grid, find_features
from core.mapping.handles.handles import Handles, ring_radius
from core.mapping.handles.plate import Frame
from core.mapping.handles.probes import Probes
from core.mapping.jacobians import Complexes, as_complex, as_positions
from core.mapping.options import Keep, MappingOptions
from core.mapping.result import Warped
from core.mapping.tolerances import UNSEEN_PX
from core.mapping.warper import Warper
from core.mapping.warping import warp_grid
from core.progress import run
from core.warps.presets import make_warp

SIZE = 242, 182
GRID = Grid(*SIZE, cell_px=4)
REST = as_complex(GRID.nodes)
OUTSIDE = np.array([[120.0, 140.0], [30.2, 40.7], [200.0, 130.0]])
INSIDE = np.array([[60.0, 110.0]])
FRAMES: list[Frame] = ["held", "free"]
BOTH = np.concatenate([OUTSIDE, INSIDE])


def mask() -> Bytes:
    found = np.zeros(SIZE[::-1], np.uint8)
    cv2.circle(found, (70, 100), 26, 255, -1)
    cv2.circle(found, (170, 80), 22, 255, -1)
    return found


def rings(*of: complex | None) -> Complexes:
    return np.array([np.nan if f is None else f for f in of], np.complex128)


def turn(degrees: float, scale: float = 1.0) -> complex:
    return complex(scale * np.exp(1j * np.radians(degrees)))


def warped(
    handles: Handles, base: Points | None = None, *, painted: Bytes | None = None, grid: Grid = GRID, **options: Any
) -> Warped:
    features = find_features(grid, mask() if painted is None else painted)
    return warp_grid(
        grid, features, grid.nodes if base is None else base, options=MappingOptions(**options), handles=handles
    )


def test_a_ring_reads_turn_and_scale_and_neither_shift_nor_shear() -> None:
    ring = Probes(np.array([[100.0, 90.0], [3.0, 2.0]]), np.array([8.0, 8.0]))
    assert ring.read(GRID, 0.7 * turn(25) * REST + (40 - 9j)) == pytest.approx(8 * 0.7 * turn(25), abs=1e-9)
    sheared = ring[:1].read(GRID, REST + 0.3 * np.conj(REST))
    assert sheared == pytest.approx(8, abs=1e-9)


def test_points_and_rings_are_the_combinations_of_the_points_they_are_spread_over() -> None:
    probes = Probes(np.array([[100.0, 90.0], [3.0, 2.0], [100.0, 90.0]]), np.array([0.0, 12.0, 12.0]))
    z = as_complex(make_warp("swirl", *SIZE, bend=50)(GRID.nodes))
    points, M = probes.spread(GRID)
    assert M.shape == (3, 9)
    assert M @ Probes.of_points(points).read(GRID, z) == pytest.approx(probes.read(GRID, z), abs=1e-9)


@pytest.mark.parametrize("keep", ["similarity", "rigid", "none"])
@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("preset", ["none", "arch"])
def test_rings_and_pins_are_met_and_nothing_folds(frame: Frame, keep: Keep, preset: str) -> None:
    base = make_warp(preset, *SIZE, bend=30)(GRID.nodes)
    scale = 1.0 if keep == "rigid" else 1.2
    asked = rings(turn(25, 0.8), None, turn(-15), turn(30, scale))
    free = warped(Handles(OUTSIDE[:0], OUTSIDE[:0]), base, keep=keep)
    to = as_positions(Probes.of_points(BOTH).read(GRID, as_complex(free.warped))) + [6.0, -4.0]
    found = warped(Handles(BOTH, to, rings=asked), base, keep=keep, frame=frame)
    assert not found.folded.any()
    assert found.turned_at(BOTH)[[0, 2, 3]] == pytest.approx(asked[[0, 2, 3]], abs=1e-5)
    assert max(pin.worst_px for pin in found.pin_reports) < 1e-3
    assert not found.missed_pins
    if keep != "none":
        assert max(feature.residual for feature in found.features) < 1e-9


@pytest.mark.parametrize("preset", ["none", "arch", "swirl"])
def test_rings_that_are_set_but_not_moved_change_no_bit(preset: str) -> None:
    base = make_warp(preset, *SIZE, bend=40)(GRID.nodes)
    without = warped(Handles(OUTSIDE[:0], OUTSIDE[:0]), base)
    there = as_positions(Probes.of_points(BOTH).read(GRID, as_complex(without.warped)))
    found = warped(Handles(BOTH, there, rings=rings(1, 1, None, 1)), base)
    assert np.array_equal(found.warped, without.warped)
    assert np.array_equal(found.plain, without.plain)


def test_a_ring_set_beside_handles_that_were_moved_moves_nothing_that_shows() -> None:
    to = BOTH + [[9, 5], [-4, 6], [2, -7], [-6, -2]]
    without = warped(Handles(BOTH, to, rings=rings(None, turn(20), None, None)))
    here = without.turned_at(BOTH)
    found = warped(Handles(BOTH, to, rings=rings(here[0], turn(20), here[2], here[3])))
    assert np.abs(without.warped - GRID.nodes).max() > 5
    assert np.abs(found.warped - without.warped).max() < 0.02


def test_a_ring_on_the_only_pin_in_a_feature_fixes_its_turn_and_size() -> None:
    found = warped(Handles(INSIDE, INSIDE, rings=rings(turn(40, 1.3))))
    feature = max(found.features, key=lambda feature: feature.angle_deg)
    assert (feature.angle_deg, feature.scale) == pytest.approx((40, 1.3), abs=1e-9)
    rigid = warped(Handles(INSIDE, INSIDE, rings=rings(turn(40, 1.3))), keep="rigid")
    feature = max(rigid.features, key=lambda feature: feature.angle_deg)
    assert (feature.angle_deg, feature.scale) == pytest.approx((40, 1.0), abs=1e-9)
    (report,) = rigid.pin_reports
    assert report.ring is not None
    assert (report.ring.scale, report.ring.reached_scale) == pytest.approx((1.3, 1), abs=1e-9)
    assert report.ring.error_px == pytest.approx(0.3 * ring_radius(GRID), abs=1e-6)
    assert rigid.missed_pins == [report]


def test_a_feature_that_a_straight_frame_cuts_grows_by_its_ring_but_does_not_turn() -> None:
    painted = np.zeros(SIZE[::-1], np.uint8)
    cv2.circle(painted, (120, SIZE[1] - 1), 30, 255, -1)
    pin = np.array([[120.0, 170.0]])
    found = warped(Handles(pin, pin, rings=rings(turn(20, 1.4))), painted=painted)
    (feature,) = found.features
    assert feature.angle_deg == pytest.approx(0, abs=1e-9)
    assert 1.2 < feature.scale < 1.45
    assert not found.folded.any()
    assert np.abs(found.warped[-1, :, 1] - GRID.nodes[-1, :, 1]).max() < 1e-9


@pytest.mark.parametrize(("degrees", "scale"), [(90, 1.0), (170, 0.8), (-120, 1.5), (0, 0.3), (0, 3.0)])
def test_far_turns_are_met_without_a_fold(degrees: float, scale: float) -> None:
    found = warped(Handles(OUTSIDE[:1], OUTSIDE[:1], rings=rings(turn(degrees, scale))))
    assert not found.folded.any()
    assert found.turned_at(OUTSIDE[:1]) == pytest.approx(turn(degrees, scale), abs=1e-3)


def test_a_mirrored_picture_has_the_mirrored_map() -> None:
    asked, flip = rings(turn(25, 0.8), None, turn(-15), turn(30)), np.array([-1.0, 1.0])
    to, shift = BOTH + [[5, 3], [-4, 6], [2, -7], [4, 5]], np.array([SIZE[0] - 1.0, 0.0])
    one = warped(Handles(BOTH, to, rings=asked))
    mirrored = Handles(BOTH * flip + shift, to * flip + shift, rings=np.conj(asked))
    other = warped(mirrored, painted=np.ascontiguousarray(mask()[:, ::-1]))
    assert np.abs(other.warped[:, ::-1] * flip + shift - one.warped).max() < 1e-3


def test_a_picture_turned_by_a_right_angle_has_the_turned_map() -> None:
    asked, grid = rings(turn(25, 0.8), None, turn(-15), turn(30)), Grid(*SIZE[::-1], cell_px=4)
    to = BOTH + [[5, 3], [-4, 6], [2, -7], [4, 5]]

    def upright(points: Points) -> Points:
        return np.stack([points[..., 1], SIZE[0] - 1 - points[..., 0]], axis=-1)

    one = warped(Handles(BOTH, to, rings=asked))
    painted = np.ascontiguousarray(np.rot90(mask()))
    other = warped(Handles(upright(BOTH), upright(to), rings=asked), painted=painted, grid=grid)
    assert np.abs(np.rot90(upright(one.warped)) - other.warped).max() < 1e-3


def test_the_order_of_pins_with_rings_changes_no_bit() -> None:
    asked, to = rings(turn(25, 0.8), None, turn(-15), turn(30)), BOTH + [[5, 3], [-4, 6], [2, -7], [4, 5]]
    one, other = (warped(Handles(BOTH[k], to[k], rings=asked[k])) for k in (range(4), [2, 0, 3, 1]))
    assert np.array_equal(one.warped, other.warped)


def test_rings_on_one_spot_agree_on_their_mean() -> None:
    twice = OUTSIDE[[0, 0]]
    found = warped(Handles(twice, twice, rings=rings(turn(10), turn(30))))
    assert found.turned_at(twice[:1]) == pytest.approx((turn(10) + turn(30)) / 2, abs=1e-5)


def test_what_is_shown_while_a_ring_is_turned_is_what_stays() -> None:
    live = Warper(GRID)
    live.use(find_features(GRID, mask()), MappingOptions())
    for degrees in range(0, 31, 3):
        handles = Handles(BOTH, BOTH, rings=rings(turn(degrees), None, None, turn(-degrees)))
        shown = live.frame(GRID.nodes, handles)
        assert not shown.folded.any()
        assert max(pin.worst_px for pin in shown.pin_reports) < UNSEEN_PX
    assert np.abs(run(live.settle(GRID.nodes, handles)).warped - shown.warped).max() < 0.1 * GRID.cell[0]


def test_rings_that_cannot_be_are_refused() -> None:
    with pytest.raises(InputError, match="3 places, but 2 rings"):
        Handles(OUTSIDE, OUTSIDE, rings=rings(1, 1))
    with pytest.raises(InputError, match="scales to nothing"):
        Handles(OUTSIDE, OUTSIDE, rings=rings(1, 0, None))
