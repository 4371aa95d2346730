"""The outline of the cloth, pixel by pixel."""

import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.pixels import outline
from core.overlay.pixels.outline import beside, beyond, without_notches
from tests.core.overlay.overlay_scenes import COLOURS, make_scene, motif

SCENE = make_scene(motif(), noise=0.01)
TEXTURE, SIZE = motif()(SCENE.uv), SCENE.shading.shape
X = np.indices(SIZE)[1]
EDGE, LOOSE = 150, 155
GROUND = np.array([0.1, 0.11, 0.1])


def on_ground(covered: Bools) -> tuple[Floats, Bools]:
    """Return a photo with cloth up to `EDGE`, dark ground beyond, and what is found to be beside it."""
    noise = np.random.default_rng(1).normal(0, 0.01, (*SIZE, 3))
    photo = np.where((X < EDGE)[..., None], SCENE.photo, GROUND + noise)
    # Beyond the edge the light has followed the ground.
    rho = np.where(X < EDGE, SCENE.shading, 0.15)
    return photo, beside(photo, TEXTURE, rho, covered, 8.0)


def test_ground_that_a_loose_region_takes_in_is_beside_the_cloth() -> None:
    _, off = on_ground(X < LOOSE)
    ends = np.where(off, X, LOOSE).min(1)
    assert np.abs(ends - EDGE).max() <= 1
    assert off[(X >= EDGE) & (X < LOOSE)].mean() > 0.98


def test_cloth_is_kept_where_its_outline_is_right() -> None:
    _, off = on_ground(X < EDGE)
    assert off.mean() < 0.001


def test_cloth_is_kept_where_more_of_it_is_beyond() -> None:
    off = beside(SCENE.photo, TEXTURE, SCENE.shading, X < 100, 8.0)
    assert off.sum() < 0.02 * 8 * SIZE[0]


def test_notches_are_closed_and_inlets_are_not() -> None:
    mask = np.ones((60, 80), bool)
    mask[:, 50:] = False
    mask[10:14, 44:] = False
    mask[30:50, 40:] = False
    closed = without_notches(mask, 5)
    assert closed[10:14, 44:48].all()
    assert not closed[33:47, 43:].any()
    assert np.array_equal(closed | mask, closed)
    assert not closed[:, 50:].any()


def test_motif_of_the_colour_of_the_ground_is_kept_where_the_edge_cuts_it(monkeypatch: pytest.MonkeyPatch) -> None:
    photo, _ = on_ground(X < EDGE)
    photo[80:84, EDGE - 3 : EDGE] = GROUND
    kept = beside(photo, TEXTURE, SCENE.shading, X < EDGE, 8.0)[78:86].sum()
    monkeypatch.setattr(outline, "NOTCH", 0.1)
    assert kept < 0.5 * beside(photo, TEXTURE, SCENE.shading, X < EDGE, 8.0)[78:86].sum()


@pytest.mark.parametrize("light", [0.45, 0.6, 0.7])
def test_outline_follows_the_edge_where_the_ground_has_a_motifs_colour(light: float) -> None:
    ground = light * COLOURS[1] + np.random.default_rng(1).normal(0, 0.01, (*SIZE, 3))
    photo = np.where((X < EDGE)[..., None], SCENE.photo, ground)
    off = beside(photo, TEXTURE, np.where(X < EDGE, SCENE.shading, 0.5), X < LOOSE, 8.0)
    ends = np.where(off, X, LOOSE).min(1)
    assert np.abs(ends - EDGE).max() <= 1
    assert np.abs(np.diff(ends)).sum() < 12


def test_whole_picture_has_nothing_beside_it() -> None:
    assert not beside(SCENE.photo, TEXTURE, SCENE.shading, np.ones(SIZE, bool), 8.0).any()
    assert not beside(SCENE.photo, TEXTURE, SCENE.shading, np.zeros(SIZE, bool), 8.0).any()


def test_cloth_goes_on_up_to_its_outline_and_no_further() -> None:
    photo, _ = on_ground(X < EDGE)
    covered, further = X < EDGE - 7, (X >= EDGE - 7) & (X < EDGE + 5)
    more = beyond(photo, TEXTURE, SCENE.shading, covered, further, 12.0, 4.0)
    assert more[:, EDGE - 7 : EDGE - 1].mean() > 0.97
    assert more[:, EDGE + 1 :].mean() < 0.01


def test_thing_that_lies_on_the_cloth_is_no_part_of_it() -> None:
    y = np.indices(SIZE)[0]
    thing = np.hypot(X - 90, y - 85) < 20
    photo = np.where(thing[..., None], [0.8, 0.55, 0.4], SCENE.photo)
    covered = np.hypot(X - 90, y - 85) > 27
    more = beyond(photo, TEXTURE, SCENE.shading, covered, ~covered & (np.hypot(X - 90, y - 85) > 15), 12.0, 4.0)
    assert more[~covered & ~thing].mean() > 0.9
    assert more[thing].mean() < 0.03
