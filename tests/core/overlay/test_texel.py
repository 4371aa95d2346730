"""What is left of a texel that changes along warp and weft alone, and what is told of one from a photo."""

from collections.abc import Callable

import numpy as np
import pytest

from core.arrays import Floats, Singles
from core.overlay.texel import Texel, estimate_texel
from tests.core.overlay.overlay_scenes import motif, plaid

SQUARE = 40.0 * np.eye(2)
SIDE, TIMES = 20, 5
"""Pixels along a texel, and texels across and down, of the photo of even cloth."""
MOTIF = slice(8, 12)


def estimated_from(photo: Floats, *, is_robust: bool) -> Floats:
    """Return the texel (SIDE, SIDE, 3) of a photo (TIMES, SIDE, TIMES, SIDE, 3) of texels that lie flat."""
    photo = photo.reshape(TIMES * SIDE, TIMES * SIDE, 3)
    v, u = (np.indices(photo.shape[:2]) + 0.5) / SIDE
    light = np.ones(photo.shape[:2])
    return estimate_texel(photo, np.stack([u, v], -1), light, light, (SIDE, SIDE), is_robust=is_robust).pixels


def even_cloth() -> Floats:
    """Return the photo (TIMES, SIDE, TIMES, SIDE, 3), texel by texel, of even cloth with a little noise."""
    noise = np.random.default_rng(0).normal(0, 0.01, (TIMES, SIDE, TIMES, SIDE, 3))
    return np.asarray(0.5 + noise, np.float64)


@pytest.mark.parametrize("scale", [SQUARE, np.array([[30.0, 4.0], [-6.0, 50.0]])])
def test_a_plaid_stays_as_it_is(scale: Floats) -> None:
    assert np.allclose(plaid().woven(scale).pixels, plaid().pixels)


def test_what_lies_across_the_threads_goes() -> None:
    t = (np.arange(60) + 0.5) / 60
    u, v = np.meshgrid(t, t)
    fold = 0.1 * np.sin(2 * np.pi * (2 * u + v))[..., None] + 0.1 * np.cos(2 * np.pi * (u - 3 * v))[..., None]
    assert np.allclose(Texel(plaid().pixels + fold).woven(SQUARE).pixels, plaid().pixels)


def test_threads_run_along_diagonals_too() -> None:
    t = (np.arange(60) + 0.5) / 60
    u, v = np.meshgrid(t, t)
    waves = np.sin(2 * np.pi * (u + v)) + 0.6 * np.sin(2 * np.pi * (u - v))
    pixels = 0.5 + 0.1 * waves[..., None] * np.ones(3)
    beside = 0.07 * np.cos(2 * np.pi * (2 * u + v))[..., None]
    assert np.allclose(Texel(pixels + beside).woven(SQUARE).pixels, pixels)


def test_a_print_loses_most() -> None:
    pixels, left = motif().pixels, motif().woven(SQUARE).pixels
    assert left.var(axis=(0, 1)).sum() < 0.7 * pixels.var(axis=(0, 1)).sum()
    assert np.allclose(left.mean((0, 1)), pixels.mean((0, 1)))


@pytest.mark.parametrize("look_up", [lambda uv: [motif().singles(uv)], motif().with_gradient])
def test_more_rows_than_opencv_takes_are_looked_up(look_up: Callable[[Floats], list[Singles]]) -> None:
    uv = np.random.default_rng(0).random((70_000, 2, 2))
    for all_of_it, some in zip(look_up(uv), look_up(uv[-9:]), strict=True):
        np.testing.assert_array_equal(all_of_it[-9:], some)


def test_nothing_is_looked_up_at_no_places() -> None:
    assert motif().singles(np.empty((0, 5, 2))).shape == (0, 5, 3)


@pytest.mark.parametrize(("is_robust", "height"), [(False, 3 / 5), (True, 1.0)])
def test_a_motif_that_most_texels_show_is_that_of_the_mean_or_of_most(is_robust: bool, height: float) -> None:
    photo = even_cloth()
    photo[:3, MOTIF, :, MOTIF] += 0.4
    texel = estimated_from(photo, is_robust=is_robust)
    assert texel[MOTIF, MOTIF].mean() - 0.5 == pytest.approx(height * 0.4, abs=0.03)
    assert texel[:5].mean() == pytest.approx(0.5, abs=0.005)
