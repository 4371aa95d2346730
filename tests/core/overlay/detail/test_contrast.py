"""The pattern in another contrast than the model's."""

import numpy as np
import pytest

from core.arrays import Singles
from core.overlay.detail.contrast import contrast_of
from core.overlay.detail.residual_cleanup import without_old_pattern
from tests.core.overlay.overlay_scenes import make_scene, motif

TEXEL = motif()
SCENE = make_scene(TEXEL, noise=0.0)
SIZE = SCENE.shading.shape
LIGHT = SCENE.shading.astype(np.float32)
UV = SCENE.uv.astype(np.float32)
MODEL = (SCENE.shading[..., None] * TEXEL(SCENE.uv)).astype(np.float32)
ALL = np.ones(SIZE, bool)
NOISE = 0.01


def faded(most: float) -> Singles:
    """Return the detail of a pattern that fades to the right, most in the first channel."""
    amount = most * np.linspace(0, 1, SIZE[1])[None, :, None] * [1.0, 0.6, 0.3]
    return np.asarray(-amount * (MODEL - MODEL.mean((0, 1))), np.float32)


def left_in(detail: Singles) -> Singles:
    found = contrast_of(detail, UV, LIGHT, TEXEL, SCENE.basis, NOISE)
    return detail - found.within(MODEL, ALL, 0)


def pattern_in(detail: Singles) -> float:
    """Return the detail on the ground less that on the motifs, first channel."""
    at = TEXEL(SCENE.uv)[..., 0]
    right = np.indices(SIZE)[1] > 90
    return float(detail[(at > 0.6) & right, 0].mean() - detail[(at < 0.3) & right, 0].mean())


def test_contrast_that_changes_over_the_cloth_goes() -> None:
    detail = faded(0.5)
    assert abs(pattern_in(detail)) > 0.15
    assert abs(pattern_in(left_in(detail))) < 0.02
    assert abs(pattern_in(without_old_pattern(detail, UV, LIGHT, TEXEL, SCENE.basis))) < 0.02


def test_rows_of_a_band_are_those_of_the_whole() -> None:
    found = contrast_of(faded(0.5), UV, LIGHT, TEXEL, SCENE.basis, NOISE)
    np.testing.assert_allclose(
        found.within(MODEL[40:90], ALL[40:90], 40), found.within(MODEL, ALL, 0)[40:90], atol=1e-6
    )


def test_stain_has_no_contrast_of_the_pattern() -> None:
    detail = np.zeros((*SIZE, 3), np.float32)
    detail[60:80, 70:95] = [0.3, 0.2, -0.2]
    assert np.abs(left_in(detail) - detail).max() < 0.05


def test_beyond_the_cloth_is_no_contrast() -> None:
    uv, inside = UV.copy(), ALL.copy()
    uv[:, :50], inside[:, :50] = np.nan, False
    found = contrast_of(np.where(inside[..., None], faded(0.5), 0.0), uv, LIGHT, TEXEL, SCENE.basis, NOISE)
    change = found.within(MODEL, inside, 0)
    assert not change[:, :50].any()
    assert np.abs(pattern_in(change)) == pytest.approx(abs(pattern_in(faded(0.5))), rel=0.1)
