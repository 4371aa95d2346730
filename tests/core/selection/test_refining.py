import cv2
import numpy as np
import pytest

from core.arrays import Bytes
from core.selection.refining import feather, fill_holes, grow, smooth


def disc(radius: int) -> Bytes:
    return np.asarray(cv2.circle(np.zeros((120, 120), np.uint8), (60, 60), radius, (255,), -1), np.uint8)


def radius_of(mask: Bytes) -> float:
    return float(np.sqrt((mask > 127).sum() / np.pi))


@pytest.mark.parametrize("px", [7.0, -7.0])
def test_an_area_grows_and_shrinks_by_pixels(px: float) -> None:
    assert radius_of(grow(disc(30), px)) == pytest.approx(radius_of(disc(30)) + px, abs=0.5)


def test_growing_by_nothing_changes_nothing() -> None:
    assert np.array_equal(grow(disc(30), 0.0), disc(30))
    assert not grow(np.zeros((5, 5), np.uint8), 9.0).any()
    assert grow(np.full((5, 5), 255, np.uint8), -9.0).all()


def test_smoothing_takes_spikes_away_and_keeps_the_rest() -> None:
    spiky = disc(30)
    spiky[59:61, 85:115] = 255
    smoothed = smooth(spiky, 4.0)
    assert not smoothed[:, 100:].any()
    assert radius_of(smoothed) == pytest.approx(radius_of(disc(30)), abs=0.6)


def test_feathering_is_a_ramp_over_the_outline() -> None:
    soft = feather(disc(30), 10.0)
    row = soft[60, 60:].astype(int)
    assert row[0] == 255
    assert row[30] == pytest.approx(127, abs=15)
    assert row[42] == 0
    assert (np.diff(row) <= 0).all()
    assert radius_of(soft) == pytest.approx(radius_of(disc(30)), abs=0.6)


def test_holes_are_filled_but_bays_are_not() -> None:
    ring = np.where(disc(15) > 0, 0, disc(30)).astype(np.uint8)
    assert np.array_equal(fill_holes(ring), disc(30))
    ring[58:62, 60:] = 0
    assert np.array_equal(fill_holes(ring), ring)


def test_a_straight_edge_moves_by_whole_pixels() -> None:
    half = np.zeros((20, 40), np.uint8)
    half[:, :10] = 255
    for px, columns in ((3.0, 13), (-3.0, 7)):
        moved = grow(half, px)
        assert (moved[:, :columns] == 255).all()
        assert not moved[:, columns:].any()
    assert grow(half, 0.5)[0, 10] == 128
