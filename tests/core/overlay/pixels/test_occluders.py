"""Things that lie on the cloth."""

import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.filters.smoothing import gaussian
from core.overlay.palette import GROUPS, palette
from core.overlay.pixels import occluders
from core.overlay.pixels.occluders import (
    disc_radii,
    find_occluders,
    hidden_pattern,
    missed_shades,
    part_sides,
    patch_colours,
    patch_sizes,
)
from core.overlay.texel import Texel
from tests.core.overlay.overlay_scenes import COLOURS, Scene, make_scene, motif

BLOTS = motif()
SCENE = make_scene(BLOTS, noise=0.01)
SIZE = SCENE.shading.shape
FULL = np.ones(SIZE, bool)
Y, X = (np.asarray(axis) for axis in np.indices(SIZE))
BELT = np.asarray(np.abs(Y - 80 - 0.1 * X) < 12, np.bool_)
PART = np.asarray((Y > 20) & (Y < 80) & (X > 30) & (X < 120), np.bool_)
NEARLY = COLOURS[0] + [0.04, 0.02, -0.14]


def dots(radius: float = 0.25, n: int = 60) -> Texel:
    """Return a texel of one dot."""
    t = (np.arange(n) + 0.5) / n - 0.5
    return Texel(np.where((np.hypot(*np.meshgrid(t, t)) < radius)[..., None], COLOURS[1], COLOURS[0]))


DOTS = dots()
DOTTED = make_scene(DOTS, basis=np.array([[14.0, 1.0], [-1.0, 13.0]]), noise=0.01)


def side(scene: Scene) -> float:
    """Return the side of a texel."""
    return float(np.sqrt(abs(np.linalg.det(scene.basis))))


def found(photo: Floats, scene: Scene = SCENE, texel: Texel = BLOTS, covered: Bools = FULL) -> Bools:
    """Return the things on a photo of a scene's cloth."""
    return find_occluders(photo, texel(scene.uv), scene.shading, texel, side(scene), covered)


def with_thing(where: Bools, colour: Floats | list[float], scene: Scene = SCENE, noise: float = 0.01) -> Floats:
    """Return the photo with a thing of a colour somewhere, in the cloth's light."""
    photo = np.where(where[..., None], scene.shading[..., None] * np.asarray(colour), scene.photo)
    return np.clip(photo + np.random.default_rng(5).normal(0, noise, photo.shape), 0, 1)


def test_cloth_alone_has_none_in_light_of_any_colour() -> None:
    assert not found(SCENE.photo).any()
    assert not found(DOTTED.photo, DOTTED, DOTS).any()
    x = np.linspace(-1, 1, SIZE[1])
    assert not found(np.clip(SCENE.photo * np.stack([1 + 0.08 * x, np.ones_like(x), 1 - 0.08 * x], -1), 0, 1)).any()


@pytest.mark.parametrize("colour", [[0.62, 0.75, 0.5], NEARLY, [0.2, 0.75, 0.2]])
@pytest.mark.parametrize("noise", [0.01, 0.05])
def test_belt_of_a_colour_that_is_none_of_the_patterns_is_one_up_to_its_edges(
    colour: list[float], noise: float
) -> None:
    off = found(with_thing(BELT, colour, noise=noise))
    assert off[BELT].mean() > 0.95
    assert off[~BELT].mean() < 0.02


def test_button_is_one() -> None:
    button = np.asarray(np.hypot(Y - 80, X - 90) < 4, np.bool_)
    off = found(with_thing(button, [0.2, 0.75, 0.2]))
    assert off[button].mean() > 0.9
    assert off[np.hypot(Y - 80, X - 90) > 7].sum() == 0


@pytest.mark.parametrize("light", [1.0, 0.85])
def test_belt_of_the_colour_of_the_ground_is_one_up_to_the_motifs(light: float) -> None:
    off = found(with_thing(BELT, light * COLOURS[0], DOTTED), DOTTED, DOTS)
    assert off[BELT].mean() > 0.95
    assert off[~BELT].mean() < 0.04


def test_belt_of_the_colour_of_a_motif_is_one() -> None:
    off = found(with_thing(BELT, COLOURS[1], DOTTED), DOTTED, DOTS)
    assert off[BELT].mean() > 0.9
    assert off[~BELT].mean() < 0.04


def test_motif_that_is_missing_is_none_and_so_is_the_ground_of_cloth_that_is_stretched() -> None:
    assert not found(
        with_thing(np.asarray(np.hypot(Y - 80, X - 90) < 7, np.bool_), COLOURS[0], DOTTED), DOTTED, DOTS
    ).any()
    wide = make_scene(DOTS, basis=1.8 * DOTTED.basis, noise=0.01)
    assert not found(wide.photo, Scene(wide.photo, wide.uv, wide.shading, DOTTED.basis), DOTS).any()


def test_motifs_that_slipped_are_none() -> None:
    photo = SCENE.photo.copy()
    photo[50:110, 50:120] = np.roll(SCENE.photo, (11, 12), (0, 1))[50:110, 50:120]
    assert found(photo)[50:110, 50:120].mean() < 0.1


def test_shadow_is_none() -> None:
    assert not found(np.where(BELT[..., None], 0.45 * SCENE.photo, SCENE.photo)).any()
    grey = Texel(np.repeat(np.where(BLOTS.pixels[..., :1] > 0.5, 0.75, 0.35), 3, -1))
    scene = make_scene(grey, noise=0.01)
    assert not found(np.where(BELT[..., None], 0.47 * scene.photo, scene.photo), scene, grey).any()


def test_what_shows_the_pattern_is_none_in_light_of_another_colour(monkeypatch: pytest.MonkeyPatch) -> None:
    blue = SCENE.photo * np.where(PART[..., None], [0.8, 0.97, 1.3], 1.0)
    assert found(blue).mean() < 0.02
    monkeypatch.setattr(occluders, "SURELY", 1e3)
    assert found(blue)[PART].mean() > 0.5


def test_small_motif_of_a_colour_of_its_own_is_none() -> None:
    t = np.linspace(0, 1, 60)[:, None, None]
    pixels = np.broadcast_to((1 - t) * COLOURS[0] + t * COLOURS[1], (60, 60, 3)).copy()
    pixels[26:34, 26:34] = [0.2, 0.75, 0.2]
    scene = make_scene(Texel(pixels), noise=0.01, basis=2 * SCENE.basis)
    assert not found(scene.photo, scene, Texel(pixels)).any()


def test_beyond_the_cloth_is_none() -> None:
    covered = np.asarray(X < 100, np.bool_)
    off = found(with_thing(BELT, NEARLY), covered=covered)
    assert not off[:, 100:].any()
    assert off[:, :98][BELT[:, :98]].mean() > 0.95
    assert not found(SCENE.photo, covered=~FULL).any()


def test_pattern_is_hidden_under_a_thing_and_seen_in_any_light() -> None:
    texture = BLOTS(SCENE.uv)
    blue = SCENE.photo * np.where(PART[..., None], [0.7, 0.95, 1.4], 1.0)
    assert np.percentile(hidden_pattern(blue, texture, FULL, 3.5)[PART], 90) < -1
    assert np.median(hidden_pattern(with_thing(BELT, COLOURS[2]), texture, FULL, 3.5)[BELT]) > 0


def test_what_all_of_a_colour_misses_alike_does_not_count_and_what_a_drawn_motif_has_is_no_miss() -> None:
    texture = BLOTS(SCENE.uv)
    ground = np.linalg.norm(texture - COLOURS[0], axis=-1) < 0.2
    photo = with_thing(np.asarray(ground, np.bool_), NEARLY)
    assert np.percentile(missed_shades(photo, texture, SCENE.shading, BLOTS, FULL, 1.5)[ground], 90) < 3
    belted = missed_shades(with_thing(BELT, NEARLY), texture, SCENE.shading, BLOTS, FULL, 1.5)
    assert np.median(belted[BELT]) > 10
    painted = np.where(BELT[..., None], NEARLY, texture)
    drawn = missed_shades(with_thing(BELT, NEARLY), painted, SCENE.shading, BLOTS, FULL, 1.5)
    assert np.median(drawn[BELT]) < 2


def test_patches_are_as_large_as_usual_but_for_those_of_things() -> None:
    texture, colours = DOTS(DOTTED.uv), patch_colours(DOTS, side(DOTTED))
    usual = patch_sizes(DOTTED.photo, texture, DOTTED.shading, colours, FULL)
    assert np.percentile(usual, 99) < 1.8
    for colour in (COLOURS[0], COLOURS[1]):
        sizes = patch_sizes(with_thing(BELT, colour, DOTTED), texture, DOTTED.shading, colours, FULL)
        assert np.median(sizes[BELT]) > 1.8


def test_radii_and_sides_of_patches() -> None:
    mask = np.zeros((60, 90), bool)
    mask[np.hypot(*np.moveaxis(np.indices(mask.shape) - np.array([30, 30])[:, None, None], 0, 0)) < 20] = True
    mask[28:33, 50:85] = True
    assert disc_radii(mask)[30, 30] == pytest.approx(20, rel=0.2)
    assert disc_radii(mask)[30, 80] < 4
    alone = mask.copy()
    alone[:, 50:52] = False
    assert part_sides(alone)[30, 80] == pytest.approx(np.sqrt(5 * 33))
    assert part_sides(alone)[30, 30] == pytest.approx(np.sqrt(np.pi) * 20, rel=0.05)


def test_motifs_of_a_few_pixels_are_told_from_the_ground_and_from_their_rims() -> None:
    assert len(patch_colours(dots(0.12), side(DOTTED))) == 2
    soft = Texel(np.asarray(gaussian(DOTS.pixels, 4.0), np.float64))
    assert len(palette(soft, GROUPS)) == 3
    assert len(patch_colours(soft, side(DOTTED))) == 2
    assert len(patch_colours(soft, 20 * side(DOTTED))) == 3
