"""Cloth sewn between the sheets that are sure."""

import numpy as np
import pytest

from core.arrays import Bools, Floats, Singles
from core.overlay.pixels.gaps.gap_completion import sew
from core.overlay.pixels.jacobian_validity import jumps, no_cloth
from core.overlay.texel import Texel

STEP = 24.0
BASIS = np.diag([STEP, STEP])
Y, X = np.indices((160, 200)).astype(float)
UV = np.stack([X / STEP + 0.2 * np.sin(Y / 50), Y / STEP + 0.2 * np.sin(X / 60)], -1)
DISC = (X - 100) ** 2 + (Y - 80) ** 2 < 24**2
TEXEL = Texel(np.kron([[0.2, 0.8], [0.7, 0.4]], np.ones((12, 12)))[..., None] * [1.0, 0.8, 0.6])
PHOTO = TEXEL(UV)


def laid(
    uv: Floats | Singles,
    photo: Floats = PHOTO,
    hidden: Bools | None = None,
) -> tuple[Singles, Bools]:
    """Sew coordinates (H, W, 2) under even light."""
    light = np.where(np.isfinite(uv[..., 0]), 1.0, np.nan).astype(np.float32)
    return sew(photo, (uv.astype(np.float32), light), TEXEL, BASIS, STEP, hidden=hidden)


def swirled(turn: float) -> Floats:
    """Turn the cloth in a disc about its middle, by less towards its rim."""
    x, y = X - 100, Y - 80
    angle = turn * np.clip(1 - np.hypot(x, y) / 24, 0, 1)
    moved = np.stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)], -1)
    return np.asarray(UV + (moved - np.stack([x, y], -1)) / STEP, np.float64)


def blown_up() -> Floats:
    return np.asarray(UV + np.where(DISC[..., None], np.stack([(100 - X) * 0.8, 0 * X], -1) / STEP, 0.0), np.float64)


def crushed() -> Floats:
    return np.asarray(UV + np.where(DISC[..., None], np.stack([(X - 100) * 2.0, 0 * X], -1) / STEP, 0.0), np.float64)


def off_px(uv: Floats | Singles) -> Floats:
    return np.asarray(np.linalg.norm((uv - UV) @ BASIS.T, axis=-1), np.float64)


@pytest.mark.parametrize("uv", [swirled(5.0), blown_up(), crushed()], ids=["swirl", "blown up", "crushed"])
def test_what_cannot_be_cloth_goes_on_with_the_cloth_around(uv: Floats) -> None:
    found, anew = laid(uv)
    assert off_px(uv).max() > 10
    assert np.percentile(off_px(found), 99.9) < 1
    assert not no_cloth(found.astype(np.float64), BASIS, STEP).any()
    assert anew[DISC].mean() > 0.5
    assert not anew[~DISC & (np.hypot(X - 100, Y - 80) > 36)].any()


def test_sure_cloth_stays_to_the_bit() -> None:
    found, anew = laid(UV)
    np.testing.assert_array_equal(found, UV.astype(np.float32))
    assert not anew.any()


@pytest.mark.parametrize("where", [np.hypot(X - 60, Y - 80) < 10, np.abs(X - Y - 20) < 4], ids=["crumb", "sliver"])
def test_what_is_too_small_or_thin_for_a_sheet_goes_on_with_the_cloth_around(where: Bools) -> None:
    found, anew = laid(UV + np.where(where[..., None], [0.5, 0.35], 0.0))
    assert off_px(found).max() < 1
    assert anew[where].all()
    assert anew[~where].mean() < 0.2


def test_a_sheet_that_is_off_by_whole_texels_is_moved_and_has_no_edge() -> None:
    found, anew = laid(UV + np.where((X > 110)[..., None], [3.0, -2.0], 0.0))
    left = found - np.rint(np.median((found - UV)[~anew], axis=0))
    assert off_px(left).max() < 1
    assert anew.mean() < 0.1


def test_a_fold_that_ends_amid_the_cloth_tears_it_in_one_line_along_the_fold() -> None:
    """It hides two texels at the top, fewer from there down; beside it, in a ragged band, nothing was followed."""
    hides = 2.0 * np.clip((90 - Y) / 50, 0, 1)
    hidden = UV + np.where(X > 100, hides, 0.0)[..., None] * [1.0, 0.0]
    followed = (np.abs(X - 100) > 10 + 4 * np.sin(Y)) | (Y > 110)
    torn = hidden + 0.4 * np.random.default_rng(0).standard_normal(UV.shape) * ~followed[..., None]
    found, anew = laid(torn, TEXEL(hidden))
    cut = np.abs(np.diff(found[..., 0], axis=1)) * STEP > 6
    assert (cut[:40].sum(1) == 1).all()
    assert np.ptp(cut[:40].argmax(1)) <= 8
    assert not cut[100:].any()
    assert no_cloth(torn, BASIS, STEP).mean() > 0.03
    assert no_cloth(found.astype(np.float64), BASIS, STEP).mean() < 0.01
    assert not anew[np.abs(X - 100) > 20].any()


def test_sides_that_miss_each_other_by_little_meet_without_a_jump() -> None:
    apart = UV + np.where((X > 100)[..., None], (0.15, 0.0), 0.0)
    found, _ = laid(apart, TEXEL(apart), hidden=np.abs(X - 100) < 15)
    assert jumps(found.astype(np.float64), BASIS).max() < 2.5


def test_a_sheet_that_the_photo_shows_stays_though_it_is_torn_from_the_cloth_around_it() -> None:
    patch = (np.abs(X - 100) < 30) & (np.abs(Y - 80) < 30)
    uv = UV + np.where(patch[..., None], [0.5, 0.5], 0.0)
    found, anew = laid(uv, TEXEL(uv))
    assert anew.mean() < 0.1
    moved = (found - uv)[~anew]
    np.testing.assert_allclose(moved, np.rint(moved), atol=1e-5)


def test_cloth_goes_on_under_what_is_hidden() -> None:
    found, anew = laid(swirled(0.4), PHOTO, hidden=DISC)
    assert anew[np.hypot(X - 100, Y - 80) < 22].all()
    assert off_px(found).max() < 1
    assert not anew[np.hypot(X - 100, Y - 80) > 28].any()


def test_sheets_far_apart_share_one_count_of_texels() -> None:
    """Nothing lies between them, nor is anything laid anew."""
    uv = UV + np.where((X >= 150)[..., None], [70.0, -41.0], 0.0)
    uv[:, 50:150] = np.nan
    found, anew = laid(uv)
    assert off_px(found)[np.isfinite(uv[..., 0])].max() < 1
    assert not anew.any()


def test_cloth_that_was_carried_on_beside_the_pattern_goes_on_with_the_cloth_around() -> None:
    wrong = UV + np.where((X > 130)[..., None], np.clip((X - 130) / 20, 0, 0.5)[..., None] * [1.0, 0.0], 0.0)
    found, anew = laid(wrong)
    assert anew[:, 160:].mean() > 0.9
    assert off_px(found).max() < 6


def test_beyond_the_cloth_is_nothing_and_scattered_cloth_stays() -> None:
    uv = swirled(5.0).astype(np.float32)
    uv[:, 110:] = np.nan
    found, anew = laid(uv)
    assert np.isnan(found[:, 110:]).all()
    assert np.isfinite(found[:, :110]).all()
    assert not anew[:, 110:].any()
    chaos = np.random.default_rng(1).random(UV.shape).astype(np.float32) * 5
    same, none = laid(chaos)
    np.testing.assert_array_equal(same, chaos)
    assert not none.any()


def test_unsure_cloth_that_hangs_together_with_no_sheet_moves_with_the_one_beside_it() -> None:
    fold, gap = (X > 90) & (X < 96), (X > 170) & (X < 176)
    uv = np.where(gap[..., None], np.nan, UV + np.where((X > 93)[..., None], [3.0, -2.0], 0.0))
    found, _ = laid(uv, np.where((fold | (X >= 176))[..., None], 0.5, PHOTO))
    assert off_px(found)[~gap].max() < 1
