"""Light and detail that go with a new texture: without the old pattern, and with the folds."""

import numpy as np
import pytest

from core.arrays import Bools, Floats, Singles
from core.overlay.detail.bare_layers import find_bare_layers, update_bare_layers
from core.overlay.filters import shrinking
from core.overlay.filters.smoothing import gaussian
from core.overlay.texel import estimate_texel
from tests.core.overlay.overlay_scenes import make_scene, motif

SCENE = make_scene(motif())
SIZE = SCENE.shading.shape
TEXEL = estimate_texel(SCENE.photo, SCENE.uv, SCENE.shading, np.ones(SIZE), (34, 36))
Y, X = np.indices(SIZE)
BESIDE: Bools = np.hypot(Y - 90, X - 100) < 35
DEEP: Bools = np.hypot(Y - 90, X - 100) < 28


def half_beside() -> Floats:
    """Return coordinates that lie about half a texel beside the pattern in a part of the cloth."""
    return np.asarray(SCENE.uv + gaussian(BESIDE.astype(np.float32), 2.0)[..., None] * [0.45, 0.4], np.float64)


def layers(photo: Floats, uv: Floats, light: Floats) -> tuple[Singles, Singles, Singles]:
    """Return detail, coordinates and light of a photo whose mesh and light are these."""
    detail = photo - light[..., None] * TEXEL(uv)
    return detail.astype(np.float32), uv.astype(np.float32), light.astype(np.float32)


def light_that_follows(photo: Floats, uv: Floats) -> Floats:
    """Return the light in which the model is as bright as the photo around each pixel, wherever it lies."""
    model = TEXEL(uv)
    both, own = (gaussian((plane * model).sum(-1).astype(np.float32), 2.0) for plane in (photo, model))
    return np.asarray(both / own, np.float64)


def off(light: Singles, where: Bools, truth: Floats = SCENE.shading) -> float:
    """Return the error of a light over the true one, but for one factor."""
    ratio = light / truth
    return float(np.std((ratio / np.median(ratio))[where]))


def test_light_is_free_of_the_pattern_where_the_mesh_lies_beside() -> None:
    uv = half_beside()
    detail, at, light = layers(SCENE.photo, uv, light_that_follows(SCENE.photo, uv))
    bare, _ = find_bare_layers(detail, at, light, TEXEL, SCENE.basis)
    assert off(light, DEEP) > 0.15
    assert off(bare, DEEP) < 0.025
    assert off(bare, ~BESIDE) < 0.02


def test_light_that_is_right_stays() -> None:
    bare, _ = find_bare_layers(*layers(SCENE.photo, SCENE.uv, SCENE.shading), TEXEL, SCENE.basis)
    assert np.abs(bare / SCENE.shading - 1).max() < 0.06
    assert np.median(bare) == pytest.approx(np.median(SCENE.shading), rel=0.005)


def test_usual_light_stays_where_less_than_a_texel_is_seen() -> None:
    detail, uv, light = layers(SCENE.photo, SCENE.uv, SCENE.shading)
    for plane in (detail, uv, light):
        plane[(Y < 60) | (Y > 72) | (X < 60) | (X > 72)] = np.nan
    bare, _ = find_bare_layers(detail, uv, light, TEXEL, SCENE.basis)
    assert np.nanmedian(bare) == pytest.approx(np.nanmedian(light), rel=0.03)


def test_a_plain_texture_shows_no_pattern_where_the_mesh_lies_beside() -> None:
    uv = half_beside()
    detail, at, light = layers(SCENE.photo, uv, light_that_follows(SCENE.photo, uv))
    shading, rest = find_bare_layers(detail, at, light, TEXEL, SCENE.basis)
    laid, wanted = 0.6 * shading[..., None] + rest, 0.6 * SCENE.shading[..., None]
    assert np.abs(laid - wanted)[DEEP].mean() < 0.02


@pytest.mark.parametrize("in_light", [False, True])
def test_a_fold_that_is_narrower_than_the_light_is_seen_on_the_new_texture(in_light: bool) -> None:
    fold = 1 - 0.3 * np.exp(-(((X + 0.4 * Y - 130) / 2.5) ** 2))
    photo = SCENE.photo * fold[..., None]
    light = SCENE.shading * fold if in_light else SCENE.shading
    shading, rest = find_bare_layers(*layers(photo, SCENE.uv, light), TEXEL, SCENE.basis)
    laid = (0.6 * shading[..., None] + rest).mean(-1) / (0.6 * SCENE.shading)
    assert laid[fold < 0.75].mean() == pytest.approx(fold[fold < 0.75].mean(), abs=0.06)
    assert laid[fold > 0.99].mean() == pytest.approx(1, abs=0.02)


def test_a_fold_is_as_deep_and_as_grey_on_a_dark_texture_as_on_a_bright_one() -> None:
    fold = 1 - 0.3 * np.exp(-(((X + 0.4 * Y - 130) / 2.5) ** 2))
    photo = SCENE.photo * fold[..., None]
    shading, rest = find_bare_layers(*layers(photo, SCENE.uv, SCENE.shading), TEXEL, SCENE.basis)
    for grey in (0.2, 0.95):
        laid = (grey * shading[..., None] + rest) / (grey * SCENE.shading)[..., None]
        assert laid[fold < 0.75].mean() == pytest.approx(fold[fold < 0.75].mean(), abs=0.1)
        assert np.ptp(laid[fold < 0.75].mean(0)) < 0.02


def test_colour_of_the_light_stays() -> None:
    tint = np.array([1.1, 1.0, 0.8])
    detail, uv, light = layers(SCENE.photo, SCENE.uv, SCENE.shading)
    coloured = (light[..., None] * tint).astype(np.float32)
    bare, _ = find_bare_layers(detail, uv, coloured, TEXEL, SCENE.basis)
    np.testing.assert_allclose(bare / bare[..., 1:2], np.broadcast_to(tint, bare.shape), rtol=1e-5)


def test_beyond_the_cloth_is_nothing() -> None:
    detail, uv, light = layers(SCENE.photo, SCENE.uv, SCENE.shading)
    detail[:, :60] = uv[:, :60] = light[:, :60] = np.nan
    shading, rest = find_bare_layers(detail, uv, light, TEXEL, SCENE.basis)
    for plane in (shading, rest[..., 0]):
        np.testing.assert_array_equal(np.isnan(plane), X < 60)
    nothing = np.full_like(light, np.nan), np.full_like(detail, np.nan)
    kept = find_bare_layers(nothing[1], nothing[1][..., :2], nothing[0], TEXEL, SCENE.basis)
    assert all(np.isnan(plane).all() for plane in kept)


def test_a_large_photo_is_looked_at_at_fewer_places_to_the_same_light(monkeypatch: pytest.MonkeyPatch) -> None:
    uv = half_beside()
    detail, at, light = layers(SCENE.photo, uv, light_that_follows(SCENE.photo, uv))
    monkeypatch.setattr(shrinking, "WORKING_PX", 95)
    bare, _ = find_bare_layers(detail, at, light, TEXEL, SCENE.basis)
    assert off(bare, DEEP) < 0.03


def test_what_has_changed_is_told_from_what_is_around_it() -> None:
    scene = make_scene(motif(), size=(300, 340))
    y, x = np.indices((300, 340))
    changed = np.hypot(y - 150, x - 170) < 25
    beside = scene.uv + gaussian(changed.astype(np.float32), 2.0)[..., None] * [0.45, 0.4]
    wrong, right = (layers(scene.photo, uv, scene.shading) for uv in (beside, scene.uv))
    before, whole = (find_bare_layers(*some, TEXEL, scene.basis) for some in (wrong, right))
    after = update_bare_layers(before, *right, TEXEL, scene.basis, changed)
    for old, new, wanted, most in zip(before, after, whole, (0.03, 0.02), strict=True):
        np.testing.assert_array_equal(new[~changed], old[~changed])
        assert np.abs(new - wanted)[changed].mean() < most / 5
        assert np.abs(new - wanted)[changed].max() < 5 * most
    assert update_bare_layers(before, *right, TEXEL, scene.basis, np.zeros_like(changed)) is before
