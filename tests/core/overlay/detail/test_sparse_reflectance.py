"""The colours of the pattern that a photo shows, wherever they lie."""

import numpy as np

from core.arrays import Singles
from core.overlay.detail.sparse_reflectance import find_reflectance
from tests.core.overlay.overlay_scenes import COLOURS

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


def test_a_fold_is_rather_a_fold_than_a_darker_colour() -> None:
    white = np.array([0.9, 0.85, 0.8], np.float32)
    grey, one = 0.8 * white, np.ones((1, 1, 3), np.float32)
    told = find_reflectance(0.85 * white * one, one[..., :1], white * one, np.stack([white, grey]), OFF)[0, 0]
    assert (told > 0.88 * white).all()


def test_colour_of_the_light_is_none_of_the_pattern() -> None:
    light = np.array([[[1.2, 1.0, 0.7]]], np.float32)
    told = find_reflectance(light * KNOWN[1], light, np.broadcast_to(KNOWN[0], (1, 1, 3)), KNOWN, OFF)
    np.testing.assert_allclose(told[0, 0], KNOWN[1], atol=0.01)


def test_what_the_model_alone_shows_is_kept() -> None:
    shown = np.array([0.9, 0.1, 0.8], np.float32)
    np.testing.assert_allclose(seen(shown, 1.0, shown), shown, atol=0.01)
