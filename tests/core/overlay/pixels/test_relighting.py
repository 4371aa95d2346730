"""Cloth on which the model cannot be trusted: its light, and its pattern found again."""

import numpy as np
import pytest

from core.arrays import Floats, Singles
from core.overlay.detail.model_validity import estimate_trust, trust_in
from core.overlay.detail.sparse_reflectance import mean_light
from core.overlay.filters.sampling import spread
from core.overlay.pixels.matching import NEXT, best_before
from core.overlay.pixels.semi_global_rematching import shifts_where_lost
from core.overlay.pixels.shading.multiscale_light import estimate_light
from core.overlay.pixels.shading.relighting import recover
from tests.core.overlay.overlay_scenes import make_scene, motif

TEXEL = motif()
SCENE = make_scene(TEXEL)
SIZE = SCENE.shading.shape
UV, LIGHT = SCENE.uv.astype(np.float32), SCENE.shading.astype(np.float32)
RIGHT = np.indices(SIZE)[1] >= 110
FULL = np.ones(SIZE, bool)
SIDE = float(np.sqrt(abs(np.linalg.det(SCENE.basis))))


def off_px(uv: Singles) -> Singles:
    """Return how far (H, W) coordinates are from the true ones or whole texels beside them, pixels."""
    off = uv - SCENE.uv
    return np.asarray(np.linalg.norm((off - np.rint(off)) @ SCENE.basis.T, axis=-1), np.float32)


def slipped() -> Singles:
    """Return coordinates that lie beside the photo on the right, further the further they are from the left."""
    part = np.clip((np.indices(SIZE)[1] - 110) / 50, 0, 1)[..., None]
    return np.asarray(UV + part * [0.35, -0.25], np.float32)


def near_light(photo: Singles, uv: Singles, around: Singles) -> Singles:
    texture = TEXEL(uv.astype(np.float64)).astype(np.float32)
    return around * estimate_light(photo, texture, around[..., None], uv, TEXEL, SCENE.basis)[..., 0]


def found_again(photo: Floats, uv: Singles) -> tuple[Singles, Singles]:
    return recover(photo, (uv, LIGHT), TEXEL, SCENE.basis, ~RIGHT)


def test_pattern_that_slipped_is_found_again() -> None:
    uv, _ = found_again(SCENE.photo, slipped())
    deep = np.indices(SIZE)[1] > 150
    assert np.median(off_px(slipped())[deep]) > 7
    assert np.median(off_px(uv)[deep]) < 2
    assert np.percentile(off_px(uv)[:, 8:-8], 90) < 3


def test_cloth_that_was_followed_and_fits_stays() -> None:
    uv, light = found_again(SCENE.photo, slipped())
    inside = np.indices(SIZE)[1] < 95
    np.testing.assert_array_equal(uv[inside], UV[inside])
    np.testing.assert_allclose(light[inside], LIGHT[inside], atol=1e-6)


def test_pattern_jumps_where_a_fold_hides_some_of_it() -> None:
    jumped = UV + np.where((RIGHT & (np.indices(SIZE)[1] > 140))[..., None], np.float32(0.5), np.float32(0.0))
    shift = shifts_where_lost(SCENE.photo.astype(np.float32), jumped, LIGHT, TEXEL, SCENE.basis, RIGHT)
    off = off_px((jumped + shift).astype(np.float32))
    assert np.median(off[:, 150:180]) < 2
    assert np.median(off[:, 112:132]) < 2
    assert not shift[~RIGHT].any()


def test_light_is_the_photos_where_cloth_was_not_followed() -> None:
    darker = np.where(RIGHT, 0.6, 1.0)
    _, light = found_again(SCENE.photo * darker[..., None], UV)
    deep = np.indices(SIZE)[1] > 135
    assert np.median((light / LIGHT)[deep]) == pytest.approx(0.6, abs=0.08)
    shading = mean_light(SCENE.photo.astype(np.float32), FULL, TEXEL, SCENE.basis)
    middle = np.s_[20:-20, 20:-20]
    assert np.abs(shading / LIGHT - 1)[middle].max() < 0.2


def test_trust_ends_where_motifs_lie_elsewhere_or_nothing_was_followed() -> None:
    photo = SCENE.photo.astype(np.float32)
    assert trust_in(photo, UV, LIGHT, TEXEL, FULL, SIDE).min() > 0.9
    wrong = np.where(RIGHT[..., None], UV + np.float32(0.5), UV)
    assert np.median(trust_in(photo, wrong, LIGHT, TEXEL, FULL, SIDE)[:, 125:]) < 0.3
    assert trust_in(photo, UV, LIGHT, TEXEL, ~RIGHT, SIDE)[:, 125:].max() == 0
    assert estimate_trust(~FULL, FULL, SIDE).min() == 1


def test_cloth_that_fits_everywhere_stays_as_it_is() -> None:
    uv, light = recover(SCENE.photo, (UV, LIGHT), TEXEL, SCENE.basis, FULL)
    np.testing.assert_allclose(uv, UV, atol=1e-6)
    np.testing.assert_allclose(light, LIGHT, atol=0.02)


def test_beyond_the_cloth_is_nothing() -> None:
    uv, light = slipped(), LIGHT.copy()
    uv[:30], light[:30] = np.nan, np.nan
    found, shading = recover(SCENE.photo, (uv, light), TEXEL, SCENE.basis, ~RIGHT & np.isfinite(light))
    assert np.isnan(found[:30]).all()
    assert np.isnan(shading[:30]).all()
    assert np.isfinite(found[30:]).all()
    assert np.isfinite(shading[30:]).all()


def test_a_spot_too_small_to_be_sure_of_stays_with_the_cloth_beside_it() -> None:
    spot = (np.abs(np.indices(SIZE)[1] - 100) < 3) & (np.abs(np.indices(SIZE)[0] - 80) < 3)
    photo = np.where(spot[..., None], np.roll(SCENE.photo, 12, 0), SCENE.photo).astype(np.float32)
    shift = shifts_where_lost(photo, UV, LIGHT, TEXEL, SCENE.basis, spot)
    assert np.abs(shift).max() < 0.1


def test_a_path_goes_to_the_next_shift_for_little_and_to_no_other() -> None:
    path = np.full((6, 5, 1), 100.0, np.float32)
    path[0, 0] = 1.0
    added = best_before(path)[..., 0]
    assert added[0, 0] == 0
    np.testing.assert_allclose([added[0, 1], added[5, 0], added[1, 0], added[0, 4]], NEXT, rtol=1e-6)
    np.testing.assert_allclose([added[1, 1], added[3, 3]], 99.0, rtol=1e-6)


def test_light_where_the_cloth_was_not_followed_is_none_that_the_cloth_has_nowhere() -> None:
    _, light = found_again(SCENE.photo * np.where(RIGHT, 3.0, 1.0)[..., None], UV)
    assert light[:, 150:].max() <= LIGHT[~RIGHT].max()


def test_cloth_on_which_only_pieces_would_fit_stays_as_it_is_carried_on() -> None:
    draw = np.random.default_rng(3).integers(0, 24, (25, 28, 2))
    pieces = np.repeat(np.repeat(draw, 7, 0), 7, 1)[: SIZE[0], : SIZE[1]]
    y, x = (np.indices(SIZE) + np.moveaxis(pieces, -1, 0)) % np.array(SIZE)[:, None, None]
    photo = np.where(RIGHT[..., None], SCENE.photo[y, x], SCENE.photo).astype(np.float32)
    shift = shifts_where_lost(photo, UV, LIGHT, TEXEL, SCENE.basis, RIGHT)
    assert (np.abs(shift).max(-1)[:, 120:] < 0.1).mean() > 0.8


@pytest.mark.parametrize("every", [2, 5])
def test_values_at_every_so_many_pixels_are_spread_to_where_they_were_taken(every: int) -> None:
    y, x = np.indices((41, 63)).astype(np.float32)
    wide = spread(np.stack([x, y], -1)[::every, ::every], (41, 63), every)
    last = [every * ((n - 1) // every) for n in (63, 41)]
    np.testing.assert_allclose(wide, np.stack([np.minimum(x, last[0]), np.minimum(y, last[1])], -1), atol=0.1)


@pytest.mark.parametrize(("share", "moves"), [(0.6, False), (0.8, True)])
def test_cloth_is_not_shifted_for_little(share: float, moves: bool) -> None:
    model, other = (LIGHT[..., None] * TEXEL(SCENE.uv + step) for step in (0.0, 0.5))
    photo = np.where(RIGHT[..., None], share * other + (1 - share) * model, model).astype(np.float32)
    shift = shifts_where_lost(photo, UV, LIGHT, TEXEL, SCENE.basis, RIGHT)
    assert ((np.abs(shift[:, 150:]).max(-1) > 0.2).mean() > 0.5) == moves


def test_shifts_across_a_cut_are_independent_and_beside_it_are_not() -> None:
    jumped = UV + np.where((RIGHT & (np.indices(SIZE)[1] > 140))[..., None], np.float32(0.5), np.float32(0.0))
    shift = shifts_where_lost(SCENE.photo.astype(np.float32), jumped, LIGHT, TEXEL, SCENE.basis, RIGHT)
    change = np.linalg.norm(np.diff(shift, axis=1) @ SCENE.basis.T, axis=-1)
    assert change[:, :125].max() < 1.2
    assert change[:, 160:].max() < 1.2


def test_light_near_a_place_shows_a_crease_that_the_light_around_does_not() -> None:
    crease = np.where(np.abs(np.indices(SIZE)[1] - 90) < 4, 0.6, 1.0)
    photo = (SCENE.photo * crease[..., None]).astype(np.float32)
    around = mean_light(photo, FULL, TEXEL, SCENE.basis)
    near = near_light(photo, UV, around)
    middle = np.s_[20:-20, 89:92]
    assert np.median(around[middle] / LIGHT[middle]) > 0.85
    assert np.median(near[middle] / LIGHT[middle]) < 0.78
    assert np.median(near[20:-20, 30:60] / LIGHT[20:-20, 30:60]) == pytest.approx(1, abs=0.05)


def test_light_near_a_place_is_that_around_where_other_motifs_are_seen() -> None:
    elsewhere = (UV + np.float32(0.5)).astype(np.float32)
    near = near_light(SCENE.photo.astype(np.float32), elsewhere, LIGHT)
    assert np.abs(near / LIGHT - 1)[20:-20, 20:-20].max() < 0.25


def test_light_of_the_model_is_not_far_over_the_photos() -> None:
    spot = np.hypot(*(np.indices(SIZE) - [[[80]], [[50]]])) < 20
    bright = np.where(spot, 2.5 * LIGHT, LIGHT).astype(np.float32)
    _, light = recover(SCENE.photo, (UV, bright), TEXEL, SCENE.basis, ~RIGHT)
    assert (light / LIGHT)[spot].max() < 1.7
