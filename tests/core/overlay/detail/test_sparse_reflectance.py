"""The colours of the pattern that a photo shows, wherever they lie."""

import numpy as np

from core.arrays import Singles
from core.overlay.detail.bare_layers import find_bare_layers
from core.overlay.detail.sparse_reflectance import find_reflectance
from tests.core.overlay.overlay_scenes import COLOURS, make_scene, motif

TEXEL = motif()
SCENE = make_scene(TEXEL, noise=0.0)
SIZE = SCENE.shading.shape
LIGHT = SCENE.shading.astype(np.float32)
UV = SCENE.uv.astype(np.float32)
MODEL = (SCENE.shading[..., None] * TEXEL(SCENE.uv)).astype(np.float32)
KNOWN = COLOURS.astype(np.float32)
OFF = 0.02


def seen(colour: Singles, light: float, shown: Singles) -> Singles:
    """Return the reflectance of one pixel of a colour in a light where light 1 is told and the model shows another."""
    one = np.ones((1, 1, 1), np.float32)
    return np.asarray(find_reflectance(light * colour * one, one, shown * one, KNOWN, OFF)[0, 0], np.float32)


def test_a_colour_of_the_pattern_is_told_wherever_it_lies() -> None:
    for colour in KNOWN:
        for shown in KNOWN:
            np.testing.assert_allclose(seen(colour, 1.0, shown), colour, atol=0.01)


def test_a_fold_is_no_other_colour() -> None:
    for colour in KNOWN:
        np.testing.assert_allclose(seen(colour, 0.8, colour), colour, atol=0.03)


def test_colour_of_the_light_is_none_of_the_pattern() -> None:
    light = np.array([[[1.2, 1.0, 0.7]]], np.float32)
    told = find_reflectance(light * KNOWN[1], light, np.broadcast_to(KNOWN[0], (1, 1, 3)), KNOWN, OFF)
    np.testing.assert_allclose(told[0, 0], KNOWN[1], atol=0.01)


def test_what_the_model_alone_shows_is_kept() -> None:
    shown = np.array([0.9, 0.1, 0.8], np.float32)
    np.testing.assert_allclose(seen(shown, 1.0, shown), shown, atol=0.01)


def faded(most: float) -> Singles:
    """Return the detail of a pattern that fades to the right, most in the first channel."""
    amount = most * np.linspace(0, 1, SIZE[1])[None, :, None] * [1.0, 0.6, 0.3]
    return np.asarray(-amount * (MODEL - MODEL.mean((0, 1))), np.float32)


def pattern_in(detail: Singles) -> float:
    """Return the detail on the ground less that on the motifs, first channel."""
    at = TEXEL(SCENE.uv)[..., 0]
    right = np.indices(SIZE)[1] > 90
    return float(detail[(at > 0.6) & right, 0].mean() - detail[(at < 0.3) & right, 0].mean())


def test_contrast_that_changes_over_the_cloth_leaves_no_pattern() -> None:
    detail = faded(0.5)
    assert abs(pattern_in(detail)) > 0.15
    assert abs(pattern_in(find_bare_layers(detail, UV, LIGHT, TEXEL, SCENE.basis)[1])) < 0.02
