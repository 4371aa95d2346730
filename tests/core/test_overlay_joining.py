"""Crumbs and slivers of cloth joined to the sheets beside them, and cloth carried on beside a sheet."""

import numpy as np
import pytest

from core.arrays import Bools, Floats, Singles
from core.overlay.continuation import continuation
from core.overlay.joining import joined, jumps

STEP = 12.0
BASIS = np.diag([STEP, STEP])
SIZE = (90, 120)
Y, X = np.indices(SIZE)
UV = np.stack([X / STEP + 0.1 * np.sin(Y / 30), Y / STEP + 0.1 * np.sin(X / 40)], -1)
BLOCK = (np.abs(X - 60) < 6) & (np.abs(Y - 45) < 6)


def with_shift(where: Bools, by: tuple[float, float] = (0.5, 0.35)) -> Floats:
    return UV + np.where(where[..., None], by, 0.0)


def off_px(uv: Floats | Singles) -> Floats:
    return np.asarray(np.linalg.norm((uv - UV) @ BASIS.T, axis=-1), np.float64)


@pytest.mark.parametrize("where", [BLOCK, np.abs(X - Y - 20) < 3], ids=["crumb", "sliver"])
def test_what_is_too_small_or_thin_for_a_sheet_goes_on_with_the_cloth_around(where: Bools) -> None:
    uv, other = joined(with_shift(where).astype(np.float32), BASIS, STEP)
    assert off_px(with_shift(where)).max() > 7
    assert off_px(uv).max() < 0.3
    assert other[where].all()
    far = np.abs(with_shift(where) - UV).max(-1) == 0
    assert other[far].mean() < 0.15


def test_a_large_sheet_keeps_its_coordinates() -> None:
    beside = with_shift(X > 70)
    uv, other = joined(beside.astype(np.float32), BASIS, STEP)
    np.testing.assert_allclose(uv, beside, atol=1e-3)
    assert not other[:, :69].any()
    assert not other[:, 73:].any()


def test_cloth_without_jumps_stays_to_the_bit() -> None:
    uv, other = joined(UV.astype(np.float32), BASIS, STEP)
    np.testing.assert_array_equal(uv, UV.astype(np.float32))
    assert not other.any()


def test_a_short_jump_within_a_sheet_is_closed_and_a_long_one_stays() -> None:
    fading = np.where(X > 60, np.clip(1 - Y / 60, 0, 1), 0.0)[..., None]
    short, long = (UV + part * fading for part in ([0.4, 0.0], [2.0, 0.0]))
    closed, _ = joined(short.astype(np.float32), BASIS, STEP)
    assert jumps(short, BASIS).max() > 4
    assert jumps(closed.astype(np.float64), BASIS).max() < 2.5
    kept, _ = joined(long.astype(np.float32), BASIS, STEP)
    np.testing.assert_allclose(kept[:20, 58:63], long[:20, 58:63], atol=0.02)


def test_a_ragged_end_of_a_sheet_is_rounded() -> None:
    teeth = np.where(Y // 3 % 2 == 0, 4, -4)
    uv, _ = joined(with_shift(teeth + 70 < X).astype(np.float32), BASIS, STEP)
    moved = off_px(uv) > 3
    ends = moved.argmax(1)[8:-8]
    assert moved.any(1).all()
    assert np.ptp(ends) <= 3


def test_beyond_the_cloth_is_nothing() -> None:
    uv = with_shift(BLOCK)
    uv[:, 64:] = np.nan
    found, other = joined(uv.astype(np.float32), BASIS, STEP)
    assert np.isnan(found[:, 64:]).all()
    assert not other[:, 64:].any()
    assert off_px(found)[:, :64].max() < 0.5


def test_cloth_that_is_all_crumbs_stays() -> None:
    uv = UV + np.random.default_rng(0).random((*SIZE, 2))
    found, other = joined(uv.astype(np.float32), BASIS, STEP)
    np.testing.assert_array_equal(found, uv.astype(np.float32))
    assert not other.any()


def test_of_a_large_picture_a_share_of_the_pixels_is_looked_at() -> None:
    y, x = np.indices((180, 240)) / 2
    fine = np.stack([x / STEP + 0.1 * np.sin(y / 30), y / STEP + 0.1 * np.sin(x / 40)], -1)
    torn = fine + np.where(((np.abs(x - 60) < 6) & (np.abs(y - 45) < 6))[..., None], [0.5, 0.35], 0.0)
    uv, other = joined(torn.astype(np.float32), BASIS, STEP, 2)
    assert np.abs(uv - fine).max() * STEP < 0.5
    assert other[90, 120]


def test_cloth_goes_straight_on_beside_a_sheet() -> None:
    plane = np.stack([0.08 * X + 0.01 * Y, 0.09 * Y - 0.02 * X], -1)
    fixed, wanted = X < 70, (X >= 70) & (X < 110)
    found = continuation(np.where(fixed[..., None], plane, np.nan), fixed, wanted, BASIS, STEP)
    np.testing.assert_allclose(found, plane[wanted], atol=1e-3)


def test_between_sides_that_miss_each_other_by_much_the_coordinates_jump_once() -> None:
    plane = np.stack([X / STEP, Y / STEP], -1)
    missed = plane + np.where((X > 60)[..., None], [3.0, 0.0], 0.0)
    wanted = np.abs(X - 60) < 8
    out = missed.copy()
    out[wanted] = continuation(missed, ~wanted, wanted, BASIS, STEP)
    steps = np.linalg.norm(np.diff(out, axis=1) @ BASIS.T, axis=-1)
    assert ((steps > 2).sum(1) == 1).all()
    assert steps.max() > 30
