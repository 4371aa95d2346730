"""Handles and features on a frame of another size, which stays a rectangle."""

import cv2
import numpy as np
import pytest

from core.grid import Grid
from core.mapping.features.similarity import fit_residual
from core.mapping.handles.handles import Handles
from core.mapping.jacobians import as_complex
from core.mapping.options import Keep
from core.mapping.result import Warped
from tests.core.mapping.test_handles import GRID, NONE, SIZE, mask, moved, places, residuals


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


@pytest.mark.parametrize(("size", "keep"), [((1, 200), "similarity"), ((300, 1), "similarity"), ((1, 1), "rigid")])
def test_sizes_of_one_pixel_are_filled_without_a_fold(size: tuple[int, int], keep: Keep) -> None:
    grid, painted = Grid(300, 220), np.zeros((220, 300), np.uint8)
    cv2.circle(painted, (80, 110), 40, 255, -1)
    cv2.circle(painted, (160, 110), 28, 255, -1)
    cv2.rectangle(painted, (210, 80), (260, 150), 255, -1)
    base = (grid.nodes + 0.5) * np.divide(size, (300, 220)) - 0.5
    found = moved(Handles(NONE, NONE), painted=painted, base=base, keep=keep, grid=grid)
    rest, z = as_complex(grid.nodes), as_complex(found.warped)
    parts = [found.marked.labels == number for number in found.marked.ids]
    assert not found.folded.any()
    assert max(fit_residual(rest[part], z[part], rigid=False) for part in parts) < 1e-6
    assert found.outline_moved_px == 0
    assert np.abs(found.warped[[0, -1], [0, -1]] - [[-0.5, -0.5], np.subtract(size, 0.5)]).max() < 1e-9


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
