"""The light in folds that are finer than the mesh."""

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.pixels.shading.multiscale_light import estimate_light
from core.overlay.texel import Texel

SIDE = 32
BASIS = np.diag([float(SIDE), float(SIDE)])
Y, X = np.indices((160, 192)).astype(float)
UV = (np.stack([X, Y], -1) / SIDE).astype(np.float32)
CHECK = ((np.arange(SIDE) < 16)[:, None] ^ (np.arange(SIDE) < 16)).astype(float)
TEXEL = Texel(np.array([0.15, 0.1, 0.1]) + CHECK[..., None] * np.array([0.6, 0.3, 0.2]))
MODEL = TEXEL(UV.astype(np.float64)).astype(np.float32)
LIGHT = np.ones((*UV.shape[:2], 1), np.float32)
FOLD = 1 - 0.3 * np.exp(-(((X - 1.1 * Y - 20) / 6) ** 2))


def light_on(photo: Floats) -> Floats:
    return estimate_light(photo, MODEL, LIGHT, UV, TEXEL, BASIS)[..., 0].astype(np.float64)


def test_a_narrow_fold_is_found_on_bright_and_dark_motifs() -> None:
    found = light_on(FOLD[..., None] * MODEL)
    inner = np.s_[16:-16, 16:-16]
    assert np.abs(found - FOLD)[inner].mean() < 0.02
    dark = MODEL.mean(-1) < 0.2
    fold = dark & (FOLD < 0.75)
    assert found[inner][fold[inner]].mean() < 0.88


def test_gathers_of_few_pixels_are_light_and_noise_and_edges_a_little_beside_are_none() -> None:
    even = (np.abs((X + 0.5) % 16 - 8) < 5) & (np.abs((Y + 0.5) % 16 - 8) < 5) & (X > 16) & (X < 176)
    gathers = 1 + 0.15 * np.sin(1.3 * X + 0.2 * Y)
    found, true = light_on(gathers[..., None] * MODEL)[even] - 1, gathers[even] - 1
    assert found @ true > 0.45 * (true @ true)
    rng = np.random.default_rng(0)
    noisy = light_on(MODEL + rng.normal(0, 0.008, MODEL.shape))
    assert noisy[even].std() < 0.5 * (0.008 / np.linalg.norm(MODEL, axis=-1))[even].mean()
    beside = light_on(TEXEL((UV + 0.4 / SIDE).astype(np.float64)))
    assert beside.std() < 0.03


def test_light_as_in_the_model_is_none() -> None:
    np.testing.assert_allclose(light_on(MODEL.astype(np.float64)), 1, atol=0.005)


def test_another_contrast_of_the_pattern_is_no_light() -> None:
    faded = 0.8 * MODEL + 0.2 * MODEL.mean((0, 1))
    found = light_on(faded)
    inner = (np.abs(X - 96) < 64) & (np.abs(Y - 80) < 48)
    assert found[inner].std() < 0.03


def test_a_motif_that_lies_elsewhere_is_no_light() -> None:
    photo = MODEL.astype(np.float64)
    spot = (np.abs(X - 104) < 7) & (np.abs(Y - 72) < 7)
    photo[spot] = MODEL.min((0, 1)) if MODEL[72, 104].mean() > 0.3 else MODEL.max((0, 1))
    assert np.abs(photo - MODEL).max() > 0.3
    np.testing.assert_allclose(light_on(photo), 1, atol=0.03)


@pytest.mark.parametrize("factor", [0.05, 20.0])
def test_what_is_no_shade_of_the_model_leaves_the_light_alone(factor: float) -> None:
    np.testing.assert_array_equal(light_on(factor * MODEL.astype(np.float64)), 1)


def test_beyond_the_cloth_the_light_is_one() -> None:
    uv = UV.copy()
    uv[:, 100:] = np.nan
    light = np.where(np.isfinite(uv[..., :1]), LIGHT, np.float32(np.nan))
    found = estimate_light(FOLD[..., None] * MODEL, MODEL, light, uv, TEXEL, BASIS)
    np.testing.assert_array_equal(found[:, 100:], 1)
    assert np.isfinite(found).all()
    assert found[:, :100].min() < 0.85


def test_of_a_large_photo_means_over_squares_tell_the_same_light() -> None:
    times = 6
    photo, model = (np.repeat(np.repeat(a, times, 0), times, 1) for a in (FOLD[..., None], MODEL))
    y, x = np.indices(model.shape[:2]).astype(np.float32)
    uv = ((np.stack([x, y], -1) - (times - 1) / 2) / (times * SIDE)).astype(np.float32)
    uv[:, -times * 30 :] = np.nan
    seen = (photo * model).astype(np.float32), model, np.ones_like(model[..., :1]), uv
    by_pixels, by_means = (estimate_light(*seen, TEXEL, times * BASIS, scale=scale) for scale in (1, times))
    change = np.abs(by_means - by_pixels)
    assert change.max() > 0
    assert change.mean() < 5e-4
    assert change.max() < 0.02
    assert by_pixels.min() < 0.8
    np.testing.assert_array_equal(by_means[np.isnan(uv[..., 0])], 1)
