"""The border of the cloth: what share of a pixel is cloth, so that a new texture leaves no rim of the old one."""

import numpy as np
import pytest

from core.arrays import Bools, Floats, Singles
from core.overlay.palette import palette
from core.overlay.pixels.matting import matte_of
from core.overlay.tolerances import RIM_PX
from tests.core.overlay.overlay_scenes import make_scene, motif

TEXEL = motif()
SCENE = make_scene(TEXEL, noise=0.005)
LIGHT = SCENE.shading[..., None].astype(np.float32)
MODEL = (LIGHT * TEXEL(SCENE.uv)).astype(np.float32)
COLOURS = palette(TEXEL, 8)
GROUND = np.array([0.15, 0.6, 0.2])


def soft_disc(radius_px: float, width_px: float) -> Floats:
    """Return the share of cloth (H, W) of a disc whose border is so wide."""
    y, x = np.indices(SCENE.shading.shape)
    return np.asarray(np.clip(0.5 + (radius_px - np.hypot(y - 85, x - 95)) / width_px, 0, 1), np.float64)


def on_ground(share: Floats, cloth: Floats | Singles) -> Floats:
    noise = np.random.default_rng(1).normal(0, 0.005, cloth.shape)
    return np.asarray(share[..., None] * cloth + (1 - share[..., None]) * GROUND + noise, np.float64)


def find_matte(photo: Floats, model: Singles, outline: Bools) -> Singles:
    everywhere = np.ones_like(outline)
    return matte_of(photo, model.__getitem__, LIGHT.__getitem__, COLOURS, outline, everywhere)


@pytest.mark.parametrize("width_px", [1.0, 3.0])
def test_share_of_cloth_is_that_which_the_photo_shows(width_px: float) -> None:
    share = soft_disc(60, width_px)
    outline = share > 0.5
    matte = find_matte(on_ground(share, MODEL), MODEL, outline)
    band = (share > 0) & (share < 1)
    assert np.abs(matte - share)[band].mean() < 0.08
    assert (matte[share == 1] > 0.9).all()
    assert (matte[soft_disc(60 + 2 * RIM_PX, 1) == 0] == 0).all()


def test_new_texture_leaves_neither_a_rim_of_the_old_one_nor_a_halo() -> None:
    share, new = soft_disc(60, 3.0), np.full(MODEL.shape, 0.9)
    photo, wanted = on_ground(share, MODEL), on_ground(share, new)
    outline = share > 0.5
    matte = find_matte(photo, MODEL, outline)[..., None]
    rim = (share > 0) & (share < 1)
    laid, sharp = photo + matte * (new - MODEL), photo + outline[..., None] * (new - MODEL)
    assert np.abs(laid - wanted)[rim].mean() < 0.05
    assert np.abs(laid - wanted)[rim].mean() < 0.4 * np.abs(sharp - wanted)[rim].mean()


def test_at_the_border_of_the_picture_cloth_is_whole() -> None:
    whole = np.ones(SCENE.shading.shape, bool)
    assert (find_matte(SCENE.photo, MODEL, whole) == 1).all()


def test_no_share_is_told_where_the_outline_is_too_wide() -> None:
    share = soft_disc(60, 1.0)
    matte = find_matte(on_ground(share, MODEL), MODEL, soft_disc(62, 1.0) > 0.5)
    beside = (share == 0) & (soft_disc(63, 1.0) > 0)
    assert (matte[beside] == 0).mean() > 0.8


def test_border_has_no_holes_where_the_model_lies_beside_the_pattern() -> None:
    share = soft_disc(60, 1.5)
    beside = (LIGHT * TEXEL(SCENE.uv + [0.3, 0.25])).astype(np.float32)
    right, wrong = (find_matte(on_ground(share, MODEL), model, share > 0.5) for model in (MODEL, beside))
    assert np.abs(wrong - share).mean() < 2 * np.abs(right - share).mean()
    assert (wrong[share == 1] > 0.3).all()
