"""A texture laid at a larger size than the photo's shows what it has at that size."""

from dataclasses import replace

import cv2
import numpy as np

from core.arrays import Floats, Singles
from core.imaging.image import Image
from core.overlay.composition import Placement
from core.overlay.laying.compositing import Parts, encode, lay_over
from core.overlay.laying.enlarging import EnlargedParts, mixed, places
from tests.core.overlay.overlay_scenes import coordinates, make_scene, motif, stored

TEXEL = motif()
SCENE = make_scene(TEXEL, noise=0.0)
HEIGHT, WIDTH = SCENE.shading.shape
CHECKS = np.kron(np.indices((12, 12)).sum(0) % 2, np.ones((16, 16)))[..., None] * np.ones(3)


def parts() -> Parts:
    everywhere = np.ones((HEIGHT, WIDTH), np.float32)
    detail = np.zeros((HEIGHT, WIDTH, 3), np.float32)
    uv, shading = SCENE.uv.astype(np.float32), SCENE.shading.astype(np.float32)
    return Parts(stored(SCENE.photo), uv, shading, detail, everywhere, SCENE.basis, TEXEL.pixels)


def doubled(source: Parts) -> EnlargedParts:
    return EnlargedParts(source, Image(np.zeros((2 * HEIGHT, 2 * WIDTH, 3), np.uint8)))


def true_uv() -> Floats:
    """Return the coordinates of a photo of twice the size."""
    y, x = (places(np.arange(2 * n), 2 * n, n) for n in (HEIGHT, WIDTH))
    down, across = np.meshgrid(y - np.rint(y), x - np.rint(x), indexing="ij")
    whole = [coordinates((HEIGHT, WIDTH), SCENE.basis, 2.5, dx, dy) for dy in (-0.25, 0.25) for dx in (-0.25, 0.25)]
    rows, columns = np.rint(y).astype(int), np.rint(x).astype(int)
    which = 2 * (down > 0) + (across > 0)
    return np.choose(which[..., None], [part[rows[:, None], columns] for part in whole])


def test_coordinates_between_pixels_are_those_of_the_cloth() -> None:
    uv, shading, _, coverage = doubled(parts()).rows(0, 2 * HEIGHT)
    assert np.abs(uv - true_uv()).max() < 2e-3
    assert coverage.min() == 1
    assert 0.6 < shading.min() <= shading.max() < 1.2
    band = doubled(parts()).rows(100, 164)[0]
    np.testing.assert_array_equal(band, uv[100:164])


def test_pieces_are_not_mixed_where_they_meet_and_nothing_is_laid_beside_the_cloth() -> None:
    source = parts()
    uv = source.uv.copy()
    uv[:, WIDTH // 2 :] += np.float32(7.4)
    uv[:, -10:] = np.nan
    coverage = source.coverage.copy()
    coverage[:, -10:] = 0
    larger, _, _, cover = doubled(replace(source, uv=uv, coverage=coverage)).rows(0, 2 * HEIGHT)
    away = (larger - true_uv())[:, :-20]
    assert np.minimum(np.abs(away), np.abs(away - 7.4)).max() < 2e-3
    assert np.isnan(larger[:, -20:]).all()
    assert cover[:, -19:].max() == 0
    assert cover[:, :-21].min() == 1


def test_fine_texture_has_detail_at_twice_the_size_that_it_lacks_at_the_photos() -> None:
    placement, source = Placement((1.0, 1.0)), parts()
    small = encode(lay_over(source, CHECKS, placement, alpha=1.0, strength=1.0))
    large = encode(lay_over(doubled(source), CHECKS, placement, alpha=1.0, strength=1.0))
    blown_up = np.asarray(cv2.resize(small, (2 * WIDTH, 2 * HEIGHT), interpolation=cv2.INTER_CUBIC), np.float64)
    inner = slice(20, -20), slice(20, -20)

    def fineness(picture: Floats | Singles) -> float:
        return float((picture - cv2.GaussianBlur(picture, (0, 0), 1.0))[inner].std())

    assert fineness(large) > 1.5 * fineness(blown_up)
    shrunk = cv2.resize(large, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    assert np.abs(shrunk - small)[inner].mean() < 0.05


def test_layers_are_mixed_by_weight_and_nan_is_nothing() -> None:
    layer = np.array([[1.0, np.nan], [3.0, 5.0]], np.float32)
    corners = [(np.array([0]), np.array([0, 1])), (np.array([1]), np.array([0, 1]))]
    got = mixed(layer, corners, [np.array([[0.5, 0.5]]), np.array([[0.5, 0.5]])])
    np.testing.assert_allclose(got, [[2.0, 2.5]])
