"""Cloth laid anew where its coordinates are folded over, blown up or crushed."""

import numpy as np
import pytest

from core.arrays import Bools, Floats, Singles
from core.overlay.joining import jumps
from core.overlay.relaying import no_cloth, relaid
from core.overlay.texel import Texel

STEP = 24.0
BASIS = np.diag([STEP, STEP])
Y, X = np.indices((160, 200)).astype(float)
UV = np.stack([X / STEP + 0.2 * np.sin(Y / 50), Y / STEP + 0.2 * np.sin(X / 60)], -1)
DISC = (X - 100) ** 2 + (Y - 80) ** 2 < 24**2


TEXEL = Texel(np.kron([[0.2, 0.8], [0.7, 0.4]], np.ones((12, 12)))[..., None] * [1.0, 0.8, 0.6])
PHOTO = TEXEL(UV)


def laid(uv: Floats | Singles, photo: Floats = PHOTO, scale: int = 1) -> tuple[Singles, Bools]:
    """Lay coordinates (H, W, 2) anew under even light."""
    light = np.where(np.isfinite(uv[..., 0]), 1.0, np.nan)
    return relaid(photo, (uv.astype(np.float32), light.astype(np.float32)), TEXEL, BASIS, STEP, scale)


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
    assert off_px(found).max() < 2
    assert not no_cloth(found.astype(np.float64), BASIS, STEP).any()
    assert anew[DISC].mean() > 0.5
    assert not anew[~DISC & (np.hypot(X - 100, Y - 80) > 36)].any()


def test_cloth_that_is_bent_or_seen_at_a_slant_stays_to_the_bit() -> None:
    uv = np.stack([X, Y], -1) / STEP
    uv[..., 0] += 0.8 * np.clip(X - 100, 0, 40) / STEP
    uv[..., 1] -= 0.4 * np.clip(Y - 80, 0, 40) / STEP
    found, anew = laid(uv)
    np.testing.assert_array_equal(found, uv.astype(np.float32))
    assert not anew.any()


def test_a_jump_between_two_sheets_stays_where_it_is() -> None:
    uv = (UV + np.where((X > 140)[..., None], (3.0, 0.4), 0.0)).astype(np.float32)
    uv[DISC] = blown_up().astype(np.float32)[DISC]
    found, _ = laid(uv)
    np.testing.assert_array_equal(found[:40, 100:], uv[:40, 100:])
    away = np.abs(X - 140.5) > 1
    assert jumps(np.where(away[..., None], found, np.nan).astype(np.float64), BASIS).max() < 2.5
    np.testing.assert_allclose(found[:, 142:], uv[:, 142:], atol=0.05)


def test_sides_that_cannot_meet_without_being_blown_up_meet_in_a_jump() -> None:
    """A fold hides two texels; beside it the cloth was followed to 10 pixels from it, and amid it is a swirl."""
    hidden = UV + np.where((X > 100)[..., None], (2.0, 0.0), 0.0)
    torn = hidden + 0.4 * np.random.default_rng(0).standard_normal(UV.shape) * (np.abs(X - 100) < 10)[..., None]
    found, _ = laid(torn)
    assert no_cloth(torn, BASIS, STEP).any()
    wild = no_cloth(found.astype(np.float64), BASIS, STEP)
    assert wild.mean() < 0.01
    sides = np.abs(X - 100) > 20
    assert np.linalg.norm(((found - hidden) @ BASIS.T)[sides], axis=-1).max() < 0.5


def test_a_fold_that_ends_amid_the_cloth_may_tear_the_sheet_that_goes_around_it() -> None:
    """A fold hides two texels at the top, fewer from there down, and none in the lower half."""
    hides = 2.0 * np.clip((90 - Y) / 50, 0, 1)
    hidden = UV + np.where(X > 100, hides, 0.0)[..., None] * [1.0, 0.0]
    beside = (np.abs(X - 100) < 10) & (Y < 70)
    torn = hidden + 0.4 * np.random.default_rng(0).standard_normal(UV.shape) * beside[..., None]
    found, _ = laid(torn)
    assert no_cloth(torn, BASIS, STEP).mean() > 0.03
    assert no_cloth(found.astype(np.float64), BASIS, STEP).mean() < 0.01


def test_a_small_sheet_stays_where_the_photo_shows_it_and_goes_on_with_the_cloth_where_not() -> None:
    corner = (X > 160) & (Y > 122)
    uv = swirled(5.0) + np.where(corner[..., None], (0.5, 0.35), 0.0)
    shown = np.where(corner[..., None], TEXEL(uv), PHOTO)
    kept, _ = laid(uv, shown)
    np.testing.assert_allclose(kept[corner], uv[corner], atol=1e-6)
    joined, anew = laid(uv, PHOTO)
    assert off_px(joined)[corner].max() < 2
    assert anew[corner].mean() > 0.9


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


def test_a_photo_of_twice_the_size_is_laid_anew_alike() -> None:
    uv = swirled(5.0).astype(np.float32)
    double = np.repeat(np.repeat(uv, 2, 0), 2, 1)
    found: list[Bools] = [laid(uv)[1], laid(double, np.repeat(np.repeat(PHOTO, 2, 0), 2, 1), 2)[1]]
    assert (found[1][::2, ::2] != found[0]).mean() < 0.01
