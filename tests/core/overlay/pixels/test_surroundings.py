"""Ground that a mesh has gone on over."""

import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.filters.k_means import find_groups
from core.overlay.pixels import surroundings as module
from core.overlay.pixels.surroundings import (
    PRIOR,
    WIDTH,
    GaussianMixture,
    find_mixture,
    find_surroundings,
    speaks_for_ground,
)
from tests.core.overlay.overlay_scenes import COLOURS, make_scene, motif

SCENE = make_scene(motif(), noise=0.01)
SIZE = SCENE.shading.shape
Y, X = (np.asarray(axis) for axis in np.indices(SIZE))
CLOTH = np.asarray(X < 90, np.bool_)
SIDE = float(np.sqrt(abs(np.linalg.det(SCENE.basis))))


def on_table() -> Floats:
    """Return a photo of the cloth on a plain table of its own colour."""
    noise = np.random.default_rng(1).normal(0, 0.01, SCENE.photo.shape)
    light = 0.97 * (0.9 + 0.2 * Y / SIZE[0])[..., None]
    return np.where(CLOTH[..., None], SCENE.photo, np.clip(light * COLOURS[0] + noise, 0, 1))


TABLE = on_table()


def test_table_of_the_cloths_colour_is_cut_off() -> None:
    covered = np.asarray(X < 150, np.bool_)
    off = find_surroundings(TABLE, covered, covered, ~covered, SIDE)
    assert off[covered & (X > 90 + SIDE)].mean() > 0.97
    assert off[covered & ~CLOTH].mean() > 0.6
    assert off[CLOTH].mean() < 0.01


def test_nothing_speaks_for_cloth_where_no_mesh_was_registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PRIOR", 100.0)
    covered = np.asarray(X < 150, np.bool_)
    assert not find_surroundings(TABLE, covered, covered, ~covered, SIDE).any()
    off = find_surroundings(TABLE, covered, CLOTH, ~covered, SIDE)
    assert off[covered & ~CLOTH].mean() > 0.6
    assert off[CLOTH].mean() < 0.01


def test_cloth_is_kept_where_its_outline_is_right() -> None:
    assert find_surroundings(TABLE, CLOTH, CLOTH, ~CLOTH, SIDE).mean() < 0.002


def test_cloth_is_kept_where_more_of_it_is_beyond() -> None:
    covered = np.asarray(X < 100, np.bool_)
    assert find_surroundings(SCENE.photo, covered, covered, ~covered, SIDE).mean() < 0.02


def test_cloth_is_kept_beside_a_band_of_its_own_colour_that_is_not_covered() -> None:
    """The last thing that a mesh reaches of a plaid is a stripe, and half of that lies beyond it."""
    stripe = np.asarray((X >= 70) & (X < 90), np.bool_)
    photo = np.where(CLOTH[..., None], SCENE.photo, np.random.default_rng(1).normal(0.5, 0.02, SCENE.photo.shape))
    photo = np.where(stripe[..., None], COLOURS[1], photo)
    covered = np.asarray(X < 80, np.bool_)
    told = find_surroundings(photo, covered, covered, ~covered, SIDE)
    assert told.any()
    assert not find_surroundings(photo, covered, covered, np.asarray(X >= 90, np.bool_), SIDE).any()


def test_belt_amid_cloth_is_none_of_the_surroundings(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "EVIDENCE", 100.0)
    belt = np.asarray((np.abs(Y - 100) < 20) & (X < 70), np.bool_)
    photo = np.where(belt[..., None], TABLE[:, ::-1], TABLE)
    assert speaks_for_ground(photo, CLOTH, CLOTH, ~CLOTH, WIDTH * SIDE, np.where(CLOTH, PRIOR, 0.0))[belt].max() > 0
    assert not find_surroundings(photo, CLOTH, CLOTH, ~CLOTH, SIDE)[belt].any()


@pytest.mark.parametrize("covered", [np.ones(SIZE, bool), np.zeros(SIZE, bool), (X < 3) & (Y < 3)])
def test_nothing_is_told_from_too_little(covered: Bools) -> None:
    assert not find_surroundings(TABLE, covered, covered, ~covered, SIDE).any()


def test_without_edges_the_outline_stays_smooth(monkeypatch: pytest.MonkeyPatch) -> None:
    covered = np.asarray(X < 150, np.bool_)
    off = find_surroundings(TABLE, covered, covered, ~covered, SIDE)
    ends = np.where(off | ~covered, X, SIZE[1]).min(1)
    assert np.ptp(ends[5:-5]) <= 8
    monkeypatch.setattr(module, "EVIDENCE", 1e-6)
    assert find_surroundings(TABLE, covered, covered, ~covered, SIDE)[CLOTH].mean() > off[CLOTH].mean()


def test_mixture_has_the_density_of_its_groups() -> None:
    rng = np.random.default_rng(0)
    values = np.concatenate([rng.normal(0, 0.2, (600, 2)), rng.normal(3, 0.1, (300, 2)), rng.normal(-4, 1, (300, 2))])
    mixture = find_mixture(values, 3)
    assert sorted(mixture.shares) == pytest.approx([0.25, 0.25, 0.5], abs=0.02)
    one = GaussianMixture(np.ones(1), np.zeros((1, 2)), 4 * np.eye(2)[None])
    at = np.array([[0.0, 0.0], [2.0, 0.0]])
    assert np.diff(one.log_likelihood(at)) == pytest.approx(-0.5)
    assert np.diff(mixture.log_likelihood(np.array([[3.0, 3.0], [1.5, 1.5]])))[0] < -20


def test_groups_are_the_same_each_time_and_no_more_than_there_are_values() -> None:
    values = np.random.default_rng(2).normal(0, 1, (50, 3)).astype(np.float32)
    labels, means = find_groups(values, 4)
    again, _ = find_groups(values, 4)
    assert np.array_equal(labels, again)
    assert np.allclose(means, [values[labels == number].mean(0) for number in range(4)], atol=1e-5)
    assert len(find_groups(values[:2], 4)[1]) == 2
