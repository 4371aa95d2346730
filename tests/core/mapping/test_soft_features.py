"""Features that are protected softly: between the plain warp and a kept shape; all others are kept exactly."""

import cv2
import numpy as np
import pytest

from core.arrays import Bytes, Points
from core.grid import Grid, find_features
from core.mapping.features.limits import Limits
from core.mapping.features.similarity import fit_residual
from core.mapping.handles.handles import Handles
from core.mapping.jacobians import as_complex
from core.mapping.options import MappingOptions
from core.mapping.result import Warped
from core.mapping.warper import Warper
from core.mapping.warping import warp_grid
from core.progress import run
from core.warps.presets import make_warp

SIZE = 300, 200
GRID = Grid(*SIZE, cell_px=4)


def mask() -> Bytes:
    found = np.zeros(SIZE[::-1], np.uint8)
    cv2.circle(found, (80, 100), 36, 255, -1)
    cv2.circle(found, (215, 110), 40, 255, -1)
    return found


FEATURES = find_features(GRID, mask())
FIRST, SECOND = FEATURES.ids.tolist()


def warped(plain: Points, weight: float | None, handles: Handles | None = None) -> Warped:
    """Return the map with the second feature protected by a weight; None takes it out of the mask."""
    features = FEATURES
    if weight is None:
        only = mask()
        only[:, 150:] = 0
        features = find_features(GRID, only)
    single = () if weight is None else ((SECOND, Limits(weight=weight)),)
    return warp_grid(GRID, features, plain, options=MappingOptions(single=single), handles=handles)


def residual(found: Warped, number: int) -> float:
    inside = FEATURES.labels == number
    return fit_residual(as_complex(GRID.nodes)[inside], as_complex(found.warped)[inside], rigid=False)


@pytest.mark.parametrize("preset", ["narrow", "arch", "twist", "inflate"])
def test_the_shape_is_kept_by_the_weight_and_other_features_exactly(preset: str) -> None:
    plain = GRID.nodes * [0.6, 1.0] if preset == "narrow" else make_warp(preset, *SIZE, bend=50)(GRID.nodes)
    found = [warped(plain, weight) for weight in (None, 0.2, 0.4, 0.6, 0.8, 0.999, 1.0)]
    left = [residual(warp, SECOND) for warp in found]
    assert left == sorted(left, reverse=True)
    assert left[3] == pytest.approx(0.4 * left[0], abs=0.25 * left[0])
    assert left[5] < 0.1 * left[0]
    assert left[6] < 1e-9
    for warp in found:
        assert residual(warp, FIRST) < 1e-9
        assert not warp.folded.any()
        assert warp.outline_moved_px == 0


def test_a_weight_near_nothing_is_the_free_picture() -> None:
    plain = make_warp("arch", *SIZE, bend=50)(GRID.nodes)
    free, found = warped(plain, None), warped(plain, 1e-9)
    assert np.abs(free.warped - found.warped).max() < 1e-5


def test_a_similar_w_is_reproduced() -> None:
    plain = GRID.nodes @ np.array([[0.9, 0.4], [-0.4, 0.9]])
    assert np.abs(warped(plain, 0.5).warped - plain).max() < 1e-8


def test_pins_hold_in_soft_features_and_one_that_is_not_moved_changes_nothing() -> None:
    plain = make_warp("arch", *SIZE, bend=40)(GRID.nodes)
    still = warped(plain, 0.5)
    at = np.array([[200.0, 100.0], [235.0, 120.0], [80.0, 100.0]])
    nodes, weights = GRID.weights_at(at)
    there = (still.warped.reshape(-1, 2)[nodes] * weights[..., None]).sum(axis=1)
    assert np.array_equal(warped(plain, 0.5, Handles(at, there)).warped, still.warped)
    found = warped(plain, 0.5, Handles(at, there + [[4.0, 6.0], [-5.0, 3.0], [3.0, -8.0]]))
    assert not found.missed_pins
    assert not found.folded.any()
    assert residual(found, FIRST) < 1e-9


def test_while_painting_soft_features_are_as_at_rest() -> None:
    plain, painted = GRID.nodes * [0.6, 1.0], mask()
    warper, options = Warper(GRID), MappingOptions(single=((SECOND, Limits(weight=0.6)),))
    warper.use(find_features(GRID, painted), options)
    warper.frame(plain)
    cv2.circle(painted, (90, 110), 36, 255, -1)
    warper.use(find_features(GRID, painted), options)
    stroke = residual(warper.frame(plain), SECOND)
    assert stroke == pytest.approx(residual(run(warper.settle(plain)), SECOND), rel=1e-3)
    assert stroke < 0.7 * residual(warped(plain, None), SECOND)
