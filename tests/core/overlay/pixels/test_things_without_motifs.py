"""Things of a pattern's ground without its motifs."""

import numpy as np

from core.arrays import Bools, Floats
from core.overlay.filters.distances import distance
from core.overlay.pixels.filling import solid
from core.overlay.pixels.occluders.things_on_cloth import find_occluders, patch_colours
from core.overlay.pixels.occluders.things_without_motifs import plain_things, stretch, usual_depth, without_holes
from core.overlay.texel import Texel
from tests.core.overlay.overlay_scenes import COLOURS, Scene, make_scene


def dots(n: int = 60) -> Texel:
    """Return a texel of one dot."""
    t = (np.arange(n) + 0.5) / n - 0.5
    return Texel(np.where((np.hypot(*np.meshgrid(t, t)) < 0.25)[..., None], COLOURS[1], COLOURS[0]))


TEXEL = dots()
BASIS = np.array([[14.0, 1.0], [-1.0, 13.0]])
SCENE = make_scene(TEXEL, basis=BASIS, noise=0.01)
SIZE = SCENE.shading.shape
Y, X = np.indices(SIZE)
BELT = np.abs(Y - 80 - 0.1 * X) < 14


def with_ground(where: Bools, scene: Scene = SCENE, light: float = 1.0) -> Floats:
    """Return the photo with the ground alone somewhere, in other light."""
    photo = np.where(where[..., None], light * scene.shading[..., None] * COLOURS[0], scene.photo)
    return np.clip(photo + np.random.default_rng(5).normal(0, 0.01, photo.shape), 0, 1)


def found(photo: Floats, scene: Scene = SCENE) -> Bools:
    """Return the things on a photo of the scene's cloth."""
    return find_occluders(photo, TEXEL(scene.uv), (scene.uv, scene.shading), TEXEL, scene.basis, np.ones(SIZE, bool))


def test_a_belt_of_the_grounds_colour_is_found_up_to_the_motifs() -> None:
    off = found(with_ground(BELT))
    assert off[BELT].mean() > 0.95
    assert off[~BELT].mean() < 0.06


def test_it_ends_at_an_edge_in_the_photo() -> None:
    off = found(with_ground(BELT, light=0.85))
    assert off[BELT].mean() > 0.95
    assert off[~BELT].mean() < 0.03


def test_a_motif_that_is_missing_is_no_thing() -> None:
    assert not found(with_ground(np.hypot(Y - 80, X - 90) < 7)).any()


def test_the_ground_of_cloth_that_is_stretched_is_none() -> None:
    wide = make_scene(TEXEL, basis=1.8 * BASIS, noise=0.01)
    scene = Scene(wide.photo, wide.uv, wide.shading, BASIS)
    assert not found(wide.photo, scene).any()
    far = np.isfinite(wide.uv[..., 0])
    assert np.allclose(np.median(stretch(wide.uv, BASIS, far, 20.0)), 1.8, rtol=0.1)


def test_its_outline_does_not_run_between_motifs() -> None:
    off = found(with_ground(BELT))
    assert (off & ~solid(off, 4)).sum() < 20


def test_holes_are_filled_and_what_is_around_is_none() -> None:
    mask = BELT.copy()
    mask[78:82, 60:64] = False
    assert np.array_equal(without_holes(mask, 30.0), BELT)
    assert np.array_equal(without_holes(mask, 1e6), BELT)


def test_nothing_is_found_where_there_is_no_ground() -> None:
    none = np.zeros(SIZE, bool)
    assert not plain_things(SCENE.photo, SCENE.uv, BASIS, none, ~none).any()


def test_the_usual_depth_is_that_of_most_texels_and_not_told_by_few() -> None:
    motifs = np.hypot(*np.moveaxis(SCENE.uv - np.floor(SCENE.uv) - 0.5, -1, 0)) < 0.25
    deep = np.asarray(distance(motifs), np.float64)
    usual = usual_depth(deep, SCENE.uv, motifs)
    assert 5 < usual < 8
    assert usual_depth(np.where(BELT, 40.0, deep), SCENE.uv, motifs) < 1.2 * usual
    few = np.where((np.abs(SCENE.uv - SCENE.uv[80, 90]) < 0.5).all(-1, keepdims=True), SCENE.uv, np.nan)
    assert usual_depth(deep, few, motifs) == np.inf


def test_motifs_of_a_few_pixels_are_told_from_the_ground() -> None:
    t = (np.arange(60) + 0.5) / 60 - 0.5
    texel = Texel(np.where((np.hypot(*np.meshgrid(t, t)) < 0.12)[..., None], COLOURS[1], COLOURS[0]))
    assert len(patch_colours(texel, BASIS)) == 2
