"""Registration of single pixels."""

import cv2
import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.filters import bands
from core.overlay.pixels.refinement import MOST_PX, refine
from core.overlay.texel import Texel, estimate_texel
from tests.core.overlay.overlay_scenes import make_scene, motif

SCENE = make_scene(motif(), noise=0.004)
TEXEL = estimate_texel(SCENE.photo, SCENE.uv, SCENE.shading, np.ones(SCENE.shading.shape), (34, 36))

LIGHT = SCENE.shading.astype(np.float32)


def misplaced(amount_px: float) -> Floats:
    """Return the scene's coordinates off by a smooth field of that many pixels at most."""
    y, x = np.indices(SCENE.shading.shape)
    off = amount_px * np.stack([np.sin(x / 9 + y / 17), np.cos(y / 11)], -1) / np.sqrt(2)
    return np.asarray(SCENE.uv + off @ np.linalg.inv(SCENE.basis).T)


def length_px(difference: Floats) -> Floats:
    return np.asarray(np.linalg.norm(difference @ SCENE.basis.T, axis=-1))


def moved(uv: Floats, texel: Texel | None = None) -> Floats:
    return np.asarray(
        refine(SCENE.photo, uv.astype(np.float32), LIGHT, texel or TEXEL, SCENE.basis),
        np.float64,
    )


def edges(uv: Floats) -> Floats:
    """Return which pixels have the edge of a motif near them."""
    _, du, dv = TEXEL.with_gradient(uv)
    return np.asarray(np.abs(du).max(-1) + np.abs(dv).max(-1) > 2)


def test_motifs_are_brought_back_to_where_they_are() -> None:
    before = misplaced(0.5)
    near = edges(SCENE.uv)
    error = [np.sqrt((length_px(uv - SCENE.uv)[near] ** 2).mean()) for uv in (before, moved(before))]
    assert error[0] > 0.3
    assert error[1] < 0.35 * error[0]


def test_what_fits_stays_where_it_is() -> None:
    assert np.percentile(length_px(moved(SCENE.uv) - SCENE.uv), 99) < 0.12


def test_even_ground_stays_where_it_is() -> None:
    plain = Texel(np.full((16, 16, 3), 0.5))
    np.testing.assert_allclose(moved(SCENE.uv, plain), SCENE.uv)


def test_no_pixel_goes_far() -> None:
    before = misplaced(3.0)
    assert 0.5 * MOST_PX < length_px(moved(before) - before).max() <= MOST_PX + 1e-4


def test_beyond_the_cloth_is_nothing() -> None:
    uv, shading = SCENE.uv.astype(np.float32), LIGHT.copy()
    uv[:, :40] = shading[:, :40] = np.nan
    out = refine(SCENE.photo, uv, shading, TEXEL, SCENE.basis)
    np.testing.assert_array_equal(np.isnan(out[..., 0]), np.isnan(shading))


def test_bands_do_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = moved(misplaced(0.5))
    monkeypatch.setattr(bands, "ROWS", 23)
    np.testing.assert_allclose(moved(misplaced(0.5)), whole, atol=1e-5)


def test_large_photo_is_moved_as_a_small_one_is() -> None:
    def enlarged(layer: Floats) -> Floats:
        return np.asarray(cv2.resize(layer, None, fx=2, fy=2, interpolation=cv2.INTER_LINEAR), np.float64)

    before = misplaced(0.5)
    uv, light = (enlarged(layer).astype(np.float32) for layer in (before, SCENE.shading))
    out = refine(enlarged(SCENE.photo), uv, light, TEXEL, 2 * SCENE.basis, every=2) - uv
    assert np.median(length_px(out[::2, ::2] - (moved(before) - before))) < 0.1
    assert np.percentile(length_px(out.astype(np.float64)), 99) > 0.45
