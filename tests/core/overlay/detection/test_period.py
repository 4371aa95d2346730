"""Telling a texel from its fractions and multiples."""

import numpy as np
import pytest

from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.period import SAMPLES, Halves, change, coarser, estimate_halves, far_period, periods
from core.overlay.detection.seeding import flat_canvas
from core.overlay.texel import Texel
from tests.core.overlay.overlay_scenes import make_scene, marked_checks, motif

HALF = np.array([[0.5, 0.5], [0.5, -0.5]])
"""Steps, in texels, after which checks look alike but for a mark."""


@pytest.mark.parametrize(("mark", "index"), [(True, 2), (False, 1)])
def test_a_mark_in_every_second_check_doubles_the_step(mark: bool, index: int) -> None:
    basis = np.array([[26.0, 2.0], [-1.0, 26.0]])
    scene = make_scene(marked_checks(mark=mark), size=(230, 240), basis=basis, noise=0.03)
    flat = scene.photo / scene.shading[..., None]
    halves = estimate_halves(flat, scene.uv @ np.linalg.inv(HALF).T, np.ones(scene.shading.shape), 2, 0)
    assert round(abs(np.linalg.det(coarser(halves).astype(float)))) == index
    assert (1, 1) in periods(halves) or not mark
    assert ((1, 0) in periods(halves)) is not mark


def striped(count: int) -> Texel:
    """Return a texel of evenly spaced stripes in both directions, all of other colours."""
    rng, t = np.random.default_rng(3), (np.arange(20 * count) + 0.5) / 20
    across, down = (
        np.where((t % 1 < 0.5)[:, None], colours[t.astype(int)], 0.9)
        for colours in rng.uniform(0.1, 0.6, (2, count, 3))
    )
    return Texel((across[None] + down[:, None]) / 2)


@pytest.mark.parametrize("count", [4, 5, 7])
def test_evenly_spaced_stripes_repeat_with_their_colours(count: int) -> None:
    scene = make_scene(striped(count), size=(230, 240), basis=9.0 * count * np.eye(2), bend=0.0)
    canvas = flat_canvas(scene.photo, np.ones((230, 240), bool))
    keys = np.stack(np.meshgrid(np.arange(2, 23), np.arange(2, 23)), -1).reshape(-1, 2)
    frames = PatchFrames(9.0 * keys.astype(np.float64), np.tile(9.0 * np.eye(2), (len(keys), 1, 1)), np.ones(len(keys)))
    assert far_period(canvas, Lattice(keys, frames)).tolist() == [count, count]


def test_texels_that_are_alike_repeat_after_one_step() -> None:
    scene = make_scene(motif(), basis=12.0 * np.eye(2), bend=1.0)
    canvas = flat_canvas(scene.photo, np.ones(scene.photo.shape[:2], bool))
    keys = np.stack(np.meshgrid(np.arange(1, 15), np.arange(1, 13)), -1).reshape(-1, 2)
    frames = PatchFrames(
        12.0 * keys.astype(np.float64), np.tile(12.0 * np.eye(2), (len(keys), 1, 1)), np.ones(len(keys))
    )
    assert far_period(canvas, Lattice(keys, frames)).tolist() == [1, 1]


def test_most_draws_decide_whether_texels_differ() -> None:
    alike = motif(SAMPLES).tiled(2, 2)
    other = alike.copy()
    other[:, :SAMPLES] = other[:, :SAMPLES, ::-1]
    same, differs = Halves(alike, alike, 2), Halves(other, other, 2)
    assert round(abs(np.linalg.det(coarser(differs).astype(float)))) == 2
    assert round(abs(np.linalg.det(coarser(differs, differs, same).astype(float)))) == 2
    assert round(abs(np.linalg.det(coarser(differs, same, same).astype(float)))) == 1


def test_texels_that_differ_a_little_are_the_same_if_others_differ_far_more() -> None:
    first = motif(SAMPLES).pixels
    soft = first + 0.22 * (first[::-1] - first)
    alike = np.hstack([first, soft])
    alone, other = np.vstack([alike, alike]), np.vstack([1 - alike, alike])
    assert (1, 0) not in periods(Halves(alone, alone, 2))
    assert (1, 0) in periods(Halves(other, other, 2))
    assert (0, 1) not in periods(Halves(other, other, 2))


def test_a_change_no_larger_than_the_noise_is_none() -> None:
    first = motif(SAMPLES).pixels
    other = 0.82 * first + 0.18 * first[::-1]
    rows = np.hstack([first, other]), np.hstack([other, first])
    noise = 0.15 * np.vstack([np.hstack([first, first]), np.hstack([1 - first, 1 - first])])
    block = np.vstack(rows)
    quiet, noisy = Halves(block, block, 2), Halves(block + noise, block - noise, 2)
    assert min(change(noisy, np.array([i, j], float))[0] for i, j in ((0, 1), (1, 0), (1, 1))) < 0
    assert (1, 0) not in periods(quiet)
    assert (1, 0) in periods(noisy)
    assert (1, 0) in periods(quiet, quiet, noisy)
