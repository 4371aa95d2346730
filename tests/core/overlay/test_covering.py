"""Cloth that was left out and is painted by hand: what lies around it goes on there."""

import numpy as np
import pytest

from core.arrays import Bools, Singles
from core.overlay.composition import Placement, finite
from core.overlay.covering import cover_painted, cover_parts
from core.overlay.laying.compositing import Parts, encode, lay_over
from core.overlay.storage.layers_file import detail_of
from tests.core.overlay.overlay_scenes import make_scene, motif, stored

SCENE = make_scene(motif(), size=(130, 150))
WIDTH, HEIGHT = 150, 130
Y, X = np.indices((HEIGHT, WIDTH))
HOLE = np.hypot(X - 70, Y - 60) < 18
"""Taken for a thing on the cloth."""
STRAIGHT = Placement((0.7, 0.7), offset=(0.2, 0.1))
TEXTURE = np.random.default_rng(3).random((12, 12, 3))


def left_out(hole: Bools, channels: tuple[int, ...] = ()) -> Parts:
    """Return the parts of the scene without those in `hole` (H, W), in light of so many channels."""
    uv = np.where(hole[..., None], np.nan, SCENE.uv).astype(np.float32)
    light = np.where(hole, np.nan, SCENE.shading).astype(np.float32)
    shading = np.ascontiguousarray(
        np.broadcast_to(light.reshape(HEIGHT, WIDTH, *[1] * len(channels)), (*light.shape, *channels))
    )
    photo, texel = stored(SCENE.photo), motif()
    detail = detail_of(encode(photo), uv, shading, texel)
    return Parts(photo, uv, shading, detail, (~hole).astype(np.float32), SCENE.basis, texel.pixels)


def painted(where: Bools, opacity: float = 1.0) -> Singles:
    return np.where(where, np.float32(opacity), np.float32(0))


@pytest.mark.parametrize("channels", [(), (3,)])
def test_cloth_goes_on_over_a_hole(channels: tuple[int, ...]) -> None:
    parts = left_out(HOLE, channels)
    layers, coverage = cover_painted((parts.uv, parts.shading), parts.coverage, painted(HOLE), parts.basis)
    uv, shading = layers
    off = np.linalg.norm((uv - SCENE.uv) @ SCENE.basis.T, axis=-1)
    assert off[HOLE].max() < 1.5
    np.testing.assert_array_equal(uv[~HOLE], parts.uv[~HOLE])
    np.testing.assert_array_equal(shading[~HOLE], parts.shading[~HOLE])
    assert shading.shape == parts.shading.shape
    assert np.abs(shading / SCENE.shading.reshape(HEIGHT, WIDTH, *[1] * len(channels)) - 1).max() < 0.3
    np.testing.assert_array_equal(coverage, 1)


def test_grey_levels_are_opacity_and_take_nothing_away() -> None:
    parts = left_out(HOLE)
    half = painted(X < 70, 0.5)
    layers, coverage = cover_painted((parts.uv, parts.shading), parts.coverage, half, parts.basis)
    np.testing.assert_array_equal(coverage, np.where(HOLE, half, 1))
    np.testing.assert_array_equal(finite(layers[0]), ~HOLE | (X < 70))


def test_cloth_goes_on_past_its_border() -> None:
    beyond = X > 120
    parts = left_out(beyond)
    layers, _ = cover_painted((parts.uv, parts.shading), parts.coverage, painted(beyond & (X < 135)), parts.basis)
    off = np.linalg.norm((layers[0] - SCENE.uv) @ SCENE.basis.T, axis=-1)[:, 121:135]
    assert np.isfinite(off).all()
    assert np.median(off) < 2
    assert np.isnan(layers[0][:, 135:]).all()


@pytest.mark.parametrize("hole", [np.ones((HEIGHT, WIDTH), bool), np.zeros((HEIGHT, WIDTH), bool)])
def test_nothing_changes_without_cloth_or_gap(hole: Bools) -> None:
    parts = left_out(hole)
    layers, coverage = cover_painted((parts.uv, parts.shading), parts.coverage, painted(X > 60), parts.basis)
    assert layers[0] is parts.uv
    np.testing.assert_array_equal(coverage, parts.coverage)


def test_texture_lies_as_before_beside_what_is_covered() -> None:
    beyond = X > 90
    parts = left_out(beyond)
    covered = cover_parts(parts, painted(beyond))
    assert (covered.norm.middle == parts.norm.middle).all()
    before, after = (lay_over(part, TEXTURE, STRAIGHT, alpha=0, strength=1).pixels for part in (parts, covered))
    np.testing.assert_array_equal(after[:, :90], before[:, :90])
    np.testing.assert_array_equal(before[:, 91:], parts.source.pixels[:, 91:])
    assert np.abs(after[:, 91:].astype(int) - before[:, 91:]).mean() > 10
