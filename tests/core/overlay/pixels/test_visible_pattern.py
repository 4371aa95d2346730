"""What shows the pattern is cloth, in whatever light; what hides it is a thing."""

import numpy as np

from core.overlay.pixels.occluders.things_on_cloth import find_occluders
from core.overlay.pixels.visible_pattern import without_cloth
from tests.core.overlay.overlay_scenes import make_scene, motif

TEXEL = motif()
SCENE = make_scene(TEXEL, noise=0.01)
TEXTURE, SIZE = TEXEL(SCENE.uv), SCENE.shading.shape
EVERYWHERE = np.ones(SIZE, bool)
PART, BELT = np.zeros(SIZE, bool), np.zeros(SIZE, bool)
PART[20:80, 30:120], BELT[120:140] = True, True


def test_of_what_is_doubted_that_stays_a_thing_which_hides_the_pattern() -> None:
    blue = SCENE.photo * np.where(PART[..., None], [0.6, 0.9, 1.5], 1.0)
    photo = np.where(BELT[..., None], [0.5, 0.4, 0.2] * SCENE.shading[..., None], blue)
    left = without_cloth(PART | BELT, photo, TEXTURE, EVERYWHERE, 12.0)
    np.testing.assert_array_equal(left, BELT)


def test_cloth_in_light_of_another_colour_is_no_thing_and_a_belt_is_one() -> None:
    blue = SCENE.photo * np.where(PART[..., None], [0.7, 0.95, 1.4], 1.0)
    layers = SCENE.uv, SCENE.shading
    assert find_occluders(blue, TEXTURE, layers, TEXEL, SCENE.basis, EVERYWHERE)[PART].mean() < 0.1
    belted = np.where(BELT[..., None], [0.62, 0.75, 0.5] * SCENE.shading[..., None], SCENE.photo)
    assert find_occluders(belted, TEXTURE, layers, TEXEL, SCENE.basis, EVERYWHERE)[BELT].mean() > 0.9
