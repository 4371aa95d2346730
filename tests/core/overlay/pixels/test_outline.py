"""The outline of the cloth, pixel by pixel."""

import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.pixels import outline
from core.overlay.pixels.outline import find_outline, reach
from tests.core.overlay.overlay_scenes import COLOURS, make_scene, motif

TEXEL = motif()
SCENE = make_scene(TEXEL, noise=0.01)
SIZE, WIDTH = SCENE.shading.shape, 8.0
Y, X = np.indices(SIZE)
EDGE = 150
GROUND = np.array([0.1, 0.3, 0.1])


def up_to(column: int) -> Bools:
    """Return the pixels (H, W) before a column."""
    return np.asarray(column > X, np.bool_)


def on_ground(ground: Floats) -> Floats:
    """Return a photo with cloth up to `EDGE`, and beyond ground of one colour."""
    noise = np.random.default_rng(1).normal(0, 0.01, (*SIZE, 3))
    return np.asarray(np.where(up_to(EDGE)[..., None], SCENE.photo, ground + noise), np.float64)


def found(photo: Floats, covered: Bools) -> Bools:
    """Return what is found to be cloth where the mesh covers so much; beyond the edge its light is the ground's."""
    return find_outline(photo, TEXEL, np.where(X < EDGE, SCENE.shading, 0.15), covered, reach(covered, WIDTH), WIDTH)


def ends(inside: Bools) -> Floats:
    """Return the column at which each row's cloth ends."""
    return np.asarray(np.where(inside, X + 1, 0).max(1), np.float64)


@pytest.mark.parametrize("last", [EDGE - 14, EDGE - 5, EDGE, EDGE + 5])
def test_cloth_ends_at_its_edge_wherever_the_mesh_does(last: int) -> None:
    inside = found(on_ground(GROUND), up_to(last))
    assert np.abs(ends(inside) - EDGE).max() <= 1
    assert inside[X < EDGE - 1].mean() > 0.99


def test_cloth_further_away_than_the_outline_is_looked_for_stays_out() -> None:
    assert not found(on_ground(GROUND), up_to(100))[X > 101 + outline.REACH * WIDTH].any()


@pytest.mark.parametrize("shade", [0.5, 0.8, 1.3])
def test_shadow_and_light_on_the_ground_are_no_cloth(shade: float) -> None:
    photo = on_ground(GROUND)
    photo[:, EDGE : EDGE + 6] *= shade
    assert np.abs(ends(found(photo, up_to(EDGE - 5))) - EDGE).max() <= 1


@pytest.mark.parametrize("light", [0.45, 0.6, 0.7])
def test_outline_follows_the_edge_where_the_ground_has_a_motifs_colour(light: float) -> None:
    inside = found(on_ground(light * COLOURS[1]), up_to(EDGE + 5))
    missed = np.abs(ends(inside) - EDGE)
    assert missed.max() <= 3
    assert missed.mean() < 0.7


def test_mesh_that_lies_beside_the_pattern_leaves_the_outline_as_it_is() -> None:
    """No place of the texel is compared: the pattern's colours are."""
    moved = make_scene(TEXEL, noise=0.01, seed=5).photo
    photo = np.where(up_to(EDGE)[..., None], moved, on_ground(GROUND))
    assert np.abs(ends(found(photo, up_to(EDGE - 5))) - EDGE).max() <= 1


def test_whole_picture_and_none_of_it_have_no_outline() -> None:
    for covered in (np.ones(SIZE, bool), np.zeros(SIZE, bool)):
        np.testing.assert_array_equal(found(SCENE.photo, covered), covered)


def test_thing_that_lies_on_the_cloth_is_no_part_of_it() -> None:
    thing = np.hypot(X - 90, Y - 85) < 20
    photo = np.where(thing[..., None], [0.8, 0.55, 0.4], SCENE.photo)
    covered = np.hypot(X - 90, Y - 85) > 27
    inside = find_outline(photo, TEXEL, SCENE.shading, covered, ~covered & (np.hypot(X - 90, Y - 85) > 10), WIDTH)
    assert inside[~covered & ~thing].mean() > 0.9
    assert inside[thing].mean() < 0.03


def test_what_is_cut_off_from_the_cloth_is_left_out() -> None:
    photo = on_ground(GROUND)
    photo[80:84, EDGE + 6 : EDGE + 10] = SCENE.photo[80:84, EDGE - 4 : EDGE]
    assert not found(photo, up_to(EDGE - 2))[80:84, EDGE + 6 : EDGE + 10].any()
