"""Large things on the cloth whose colour is near one of the pattern's."""

import numpy as np

from core.arrays import Floats
from core.overlay.pixels.occluders.things_of_other_colour import foreign_things, misses
from tests.core.overlay.overlay_scenes import COLOURS, make_scene, motif

TEXEL = motif()
SCENE = make_scene(TEXEL)
SIZE = SCENE.shading.shape
FULL = np.ones(SIZE, bool)
BELT = np.abs(np.indices(SIZE)[0] - 80 - 0.1 * np.indices(SIZE)[1]) < 10
NEARLY = COLOURS[0] + [0.04, 0.02, -0.14]


def with_thing(where: Floats) -> Floats:
    photo = np.where(where[..., None] > 0, SCENE.shading[..., None] * NEARLY, SCENE.photo)
    return np.clip(photo + np.random.default_rng(5).normal(0, 0.01, photo.shape), 0, 1)


def found(photo: Floats) -> Floats:
    return foreign_things(photo, SCENE.shading, TEXEL, SCENE.basis, FULL).astype(float)


def test_a_belt_of_nearly_the_grounds_colour_is_found_to_its_edges() -> None:
    belt = found(with_thing(BELT.astype(float)))
    assert belt[BELT].mean() > 0.93
    assert belt[~BELT].mean() < 0.02


def test_cloth_alone_has_no_such_thing_in_any_light() -> None:
    assert not found(SCENE.photo).any()
    x = np.linspace(-1, 1, SIZE[1])
    colour = np.stack([1 + 0.08 * x, np.ones_like(x), 1 - 0.08 * x], -1)
    assert not found(np.clip(SCENE.photo * colour, 0, 1)).any()


def test_what_a_colour_of_the_pattern_misses_everywhere_alike_does_not_count() -> None:
    ground = np.linalg.norm(TEXEL(SCENE.uv) - COLOURS[0], axis=-1) < 0.2
    photo = with_thing(ground.astype(float))
    assert np.abs(np.median(misses(photo, SCENE.shading, TEXEL, FULL)[ground], axis=0)).max() < 0.01
    assert not found(photo).any()


def test_a_small_or_thin_thing_is_not_looked_for_here() -> None:
    y, x = np.indices(SIZE)
    assert not found(with_thing((np.hypot(y - 80, x - 90) < 6).astype(float))).any()
    assert not found(with_thing((np.abs(y - 80) < 1).astype(float))).any()


def test_beyond_the_cloth_is_no_thing() -> None:
    covered = np.indices(SIZE)[1] < 100
    things = foreign_things(with_thing(BELT.astype(float)), SCENE.shading, TEXEL, SCENE.basis, covered)
    assert not things[:, 100:].any()
    assert things[:, :95][BELT[:, :95]].mean() > 0.9
    assert not foreign_things(SCENE.photo, SCENE.shading, TEXEL, SCENE.basis, ~FULL).any()


def test_an_edge_in_the_photo_is_the_things_outline() -> None:
    y, x = np.indices(SIZE)
    belt = (np.abs(y - 80) < 10) & (x > 40)
    faint = np.where(belt[..., None], SCENE.shading[..., None] * NEARLY, SCENE.photo)
    noisy = np.clip(faint + np.random.default_rng(6).normal(0, 0.05, faint.shape), 0, 1)
    off = found(noisy) > 0
    assert off[belt].mean() > 0.9
    assert off[~belt].mean() < 0.02


def test_a_further_part_of_a_thing_may_be_small() -> None:
    y, x = np.indices(SIZE)
    button = np.hypot(y - 140, x - 90) < 6
    assert not found(with_thing(button.astype(float))).any()
    assert found(with_thing((BELT | button).astype(float)))[button].mean() > 0.9
