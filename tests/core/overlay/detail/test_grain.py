"""The grain of the cloth in a detail, at the places of the texel where the model makes errors."""

import numpy as np

from core.arrays import Singles
from core.overlay.detail.grain import grain_of, without_tint
from core.overlay.filters.smoothing import gaussian, mean
from core.overlay.tolerances import NEARBY_PX
from tests.core.overlay.overlay_scenes import make_scene, motif

TEXEL = motif()
SCENE = make_scene(TEXEL, noise=0.0)
SIZE = SCENE.shading.shape
UV = SCENE.uv.astype(np.float32)
CLEAR = np.ones(SIZE, bool)
_, DU, DV = TEXEL.with_gradient(SCENE.uv)
STEEP = np.abs(DU).max(-1) + np.abs(DV).max(-1)
EDGE, PLAIN = gaussian((STEEP > 3).astype(np.float32), 1.0) > 0.5, STEEP < 0.3

RNG = np.random.default_rng(4)
GREY = 0.02 * RNG.normal(size=(*SIZE, 1)).astype(np.float32) * np.ones(3, np.float32)
"""Grain of cloth: the same in all channels."""
RED = 0.08 * RNG.normal(size=(*SIZE, 1)).astype(np.float32) * np.array([1.0, 0.1, 0.1], np.float32) * EDGE[..., None]
"""Errors at the edges of motifs, mostly of one channel."""


def likeness(a: Singles, b: Singles) -> float:
    return float(np.corrcoef(a.ravel(), b.ravel())[0, 1])


def test_errors_of_one_channel_go_and_the_grain_under_them_stays() -> None:
    detail = GREY + RED
    fine = detail - mean(detail, np.ones((*SIZE, 1), np.float32), NEARBY_PX)
    grain = grain_of(detail, UV, CLEAR, TEXEL.shape, SCENE.basis)
    kept = grain.within(fine, SCENE.uv)
    assert likeness(detail[EDGE], GREY[EDGE]) < 0.65
    assert likeness(kept[EDGE], GREY[EDGE]) > 0.75
    assert kept[EDGE][:, 0].std() < 1.3 * GREY[EDGE][:, 0].std()
    assert likeness(kept[PLAIN], GREY[PLAIN]) > 0.95


def test_faint_tint_goes_and_a_strong_colour_stays() -> None:
    coarse = np.array([[[0.04, -0.02, -0.02], [-0.2, -0.2, -0.2], [0.4, -0.2, -0.2]]], np.float32)
    np.testing.assert_allclose(without_tint(coarse)[0, 0], 0.0, atol=0.005)
    np.testing.assert_allclose(without_tint(coarse)[0, 1:], coarse[0, 1:], atol=0.02)
