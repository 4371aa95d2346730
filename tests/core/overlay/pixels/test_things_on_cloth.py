"""Things on the cloth that have a colour of its pattern."""

import cv2
import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.pixels.occluders.things_on_cloth import find_occluders
from core.overlay.texel import Texel
from tests.core.overlay.overlay_scenes import COLOURS, make_scene, motif

TEXEL = motif()
SCENE = make_scene(TEXEL, noise=0.01)
TEXTURE, SIZE = TEXEL(SCENE.uv), SCENE.shading.shape


def found(photo: Floats) -> Bools:
    """Return the things found on a photo of the scene's cloth."""
    return find_occluders(photo, TEXTURE, (SCENE.uv, SCENE.shading), TEXEL, SCENE.basis, np.ones(SIZE, bool))


def with_bow(colour: Floats) -> tuple[Floats, Bools]:
    """Return the photo with a cross of a colour on it, and where that is."""
    y, x = np.indices(SIZE)
    bow = ((np.abs(y - x) < 7) | (np.abs(y + x - 160) < 7)) & (np.hypot(y - 80, x - 80) < 38)
    return np.where(bow[..., None], colour * SCENE.shading[..., None], SCENE.photo), bow


def test_bow_of_the_colour_of_a_motif_is_a_thing() -> None:
    photo, bow = with_bow(COLOURS[1])
    off = found(photo)
    assert off[bow].mean() > 0.95
    assert off[~bow].mean() < 0.1


GREEN, BLACK = [0.2, 0.75, 0.2], [0.03, 0.03, 0.03]


@pytest.mark.parametrize(
    ("colour", "height", "width", "thing"),
    [(GREEN, 7, 7, True), (GREEN, 1, 40, False), (GREEN, 3, 3, False), (BLACK, 7, 7, False)],
)
def test_button_of_another_colour_is_a_thing_and_a_seam_a_speck_or_a_shadow_is_none(
    colour: list[float], height: int, width: int, thing: bool
) -> None:
    button = np.zeros(SIZE, bool)
    button[77 : 77 + height, 90 : 90 + width] = True
    off = found(np.where(button[..., None], np.array(colour), SCENE.photo))
    assert off[button].mean() > 0.9 if thing else not off.any()
    near = cv2.dilate(button.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    assert not off[~near].any()


def test_motifs_are_none() -> None:
    assert not found(SCENE.photo).any()


def test_patch_of_the_ground_that_is_no_wider_than_the_patterns_may_be_of_any_size() -> None:
    photo, _ = with_bow(COLOURS[0])
    assert not found(photo).any()


def test_motifs_that_slipped_are_none() -> None:
    photo = SCENE.photo.copy()
    photo[50:110, 50:120] = np.roll(SCENE.photo, (11, 12), (0, 1))[50:110, 50:120]
    assert not found(photo).any()


def test_shadow_is_none() -> None:
    photo, bow = with_bow(COLOURS[1])
    shaded = np.where(bow[..., None], 0.45 * SCENE.photo, SCENE.photo)
    assert not found(shaded).any()
    assert found(photo).any()


def test_shadow_that_looks_like_a_darker_motif_is_none() -> None:
    grey = Texel(np.repeat(np.where(TEXEL.pixels[..., :1] > 0.5, 0.75, 0.35), 3, -1))
    scene = make_scene(grey, noise=0.01)
    _, bow = with_bow(COLOURS[1])
    photo = np.where(bow[..., None], 0.47 * scene.photo, scene.photo)
    assert not find_occluders(
        photo, grey(scene.uv), (scene.uv, scene.shading), grey, scene.basis, np.ones(SIZE, bool)
    ).any()


def test_patch_amid_cloth_that_lies_elsewhere_is_none() -> None:
    photo, _ = with_bow(COLOURS[1])
    slipped = np.roll(TEXTURE, (11, 12), (0, 1))
    assert not find_occluders(photo, slipped, (SCENE.uv, SCENE.shading), TEXEL, SCENE.basis, np.ones(SIZE, bool)).any()


def test_small_motif_of_a_colour_of_its_own_is_none() -> None:
    t = np.linspace(0, 1, 60)[:, None, None]
    pixels = np.broadcast_to((1 - t) * COLOURS[0] + t * COLOURS[1], (60, 60, 3)).copy()
    pixels[26:34, 26:34] = GREEN
    texel = Texel(pixels)
    scene = make_scene(texel, noise=0.01, basis=2 * SCENE.basis)
    texture, layers, every = texel(scene.uv), (scene.uv, scene.shading), np.ones(SIZE, bool)
    assert not find_occluders(scene.photo, texture, layers, texel, scene.basis, every).any()
    plain = Texel(np.where(np.isclose(pixels, GREEN).all(-1, keepdims=True), COLOURS[0], pixels))
    assert find_occluders(scene.photo, plain(scene.uv), layers, texel, scene.basis, every).any()
