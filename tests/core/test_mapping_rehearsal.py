"""Unfolding that saves time: folds cleared on a coarser grid, steps that go on, sizes that are not tried in vain."""

import cv2
import numpy as np
import pytest

from core.arrays import Bytes
from core.grid import Grid, find_features
from core.mapping import own_sizes, untangle
from core.mapping.approach import count_folds, placed
from core.mapping.distortion import Barrier
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.frames import Complexes, as_complex
from core.mapping.junctions import fitted_places, folds_corners, largest_scales
from core.mapping.own_sizes import bisected
from core.mapping.rehearsal import Rehearsal
from core.mapping.similarity import fit_residual
from core.mapping.untangle import Untangler
from core.progress import Job, Progress, run
from core.warps.presets import make_warp

WIDTH, HEIGHT = 240, 180
GRID = Grid(WIDTH, HEIGHT, cell_px=3)
FINE = Grid(WIDTH, HEIGHT, cell_px=1.5)


def near_the_edge() -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    cv2.circle(mask, (120, 90), 70, 255, -1)
    return mask


def across() -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    mask[60:120] = 255
    return mask


def folding(grid: Grid, bend: float) -> tuple[FeatureMapping, Complexes, Solution]:
    """Return a mapping, a W without folds and the linear answer, which folds."""
    mapping = FeatureMapping(grid, find_features(grid, near_the_edge()), keep="rigid")
    w = as_complex(make_warp("squeeze", WIDTH, HEIGHT, bend=bend)(grid.nodes))
    return mapping, w, mapping.place(w)


def test_many_folds_are_cleared_on_a_coarser_grid_and_features_stay() -> None:
    mapping, w, linear = folding(FINE, 70)
    rehearsal = Rehearsal(mapping, w)
    found = run(rehearsal.cleared(linear))
    assert count_folds(linear) > 100
    assert count_folds(found) < count_folds(linear) / 10
    assert np.allclose(found.alpha, linear.alpha)
    assert np.allclose(found.t, linear.t)
    body = mapping.bodies[0].nodes
    assert np.allclose(found.z.ravel()[body], linear.z.ravel()[body])
    assert fit_residual(as_complex(FINE.nodes).ravel()[body], found.z.ravel()[body], rigid=True) < 1e-9
    assert np.array_equal(found.z[FINE.outline], w[FINE.outline])


def test_folds_that_the_coarser_grid_leaves_are_counted() -> None:
    mapping, w, linear = folding(FINE, 85)
    rehearsal = Rehearsal(mapping, w)
    found = run(rehearsal.cleared(linear))
    assert found is linear
    assert rehearsal.left == count_folds(linear) > 1000


def test_a_small_grid_and_one_whose_coarser_w_folds_are_left_as_they_are() -> None:
    mapping, w, linear = folding(Grid(WIDTH, HEIGHT, cell_px=6), 70)
    assert run(Rehearsal(mapping, w).cleared(linear)) is linear
    mapping, w, linear = folding(FINE, 70)
    w = w.copy()
    w[:, ::3] = w[:, ::3].mean()
    assert run(Rehearsal(mapping, w).cleared(linear)) is linear


def test_an_untangler_in_which_nothing_moves_takes_no_step() -> None:
    mapping, w, linear = folding(GRID, 70)
    untangler = Untangler(mapping, w, linear, window=np.zeros(GRID.shape, bool), stiffness=None)
    assert not untangler.step(Barrier(0.1), 1.0)
    assert np.array_equal(untangler.solution.z, linear.z)


def test_steps_on_deep_folds_go_on_as_long_as_the_energy_falls(monkeypatch: pytest.MonkeyPatch) -> None:
    mapping, w, linear = folding(GRID, 70)
    barrier, energies = Barrier(0.1), []
    for furthest in (1.0, 4.0):
        monkeypatch.setattr(untangle, "_FURTHEST", furthest)
        untangler = Untangler(mapping, w, linear, window=np.ones(GRID.shape, bool), stiffness=None)
        assert all(untangler.step(barrier, 100.0) for _ in range(4))
        energies.append(untangler._energy(barrier, 100.0))
    assert energies[1] < 0.99 * energies[0]


def test_the_largest_scale_of_a_strip_is_what_the_outline_leaves_it() -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, across()))
    rows = np.ptp(np.nonzero((mapping.index >= 0).any(axis=1))[0])
    w = as_complex(GRID.nodes * [1.0, 0.5])
    assert largest_scales(mapping, w, 1) == pytest.approx(0.5 * (rows + 2) / rows, rel=1e-2)
    inside = across()
    inside[:, :40] = inside[:, -40:] = 0
    assert largest_scales(FeatureMapping(GRID, find_features(GRID, inside)), w, 1) == np.inf


def test_a_feature_is_fitted_at_its_size_where_room_is_worth_none_of_it() -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, across()), keep="rigid")
    w = as_complex(GRID.nodes * [1.0, 0.5])
    linear, largest = mapping.place(w), float(largest_scales(mapping, w, 1)[0])
    roomy, tight = (fitted_places(mapping, w, linear.alpha, linear.t, worth=worth) for worth in (0.05, 0.0))
    assert roomy is not None
    assert tight is not None
    assert abs(roomy[0][0]) < 0.99 * abs(tight[0][0])
    assert abs(tight[0][0]) < largest
    assert not folds_corners(mapping, w, *tight)


def test_sizes_that_the_outline_leaves_no_room_for_are_not_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, across()), keep="rigid")
    w = as_complex(GRID.nodes * [1.0, 0.5])
    linear, largest = mapping.place(w), largest_scales(mapping, w, 1)
    small = placed(mapping, linear, linear.alpha * 0.99 * largest, linear.t)
    monkeypatch.setattr(own_sizes, "_cleared", lambda *_: pytest.fail("a size beyond the largest has been tried"))
    assert run(bisected(mapping, w, small, Rehearsal(mapping, w))) is small


class Hopeless(Rehearsal):
    """A coarser grid on which nothing can be cleared."""

    def cleared(self, solution: Solution) -> Job[Solution]:
        self.left = 100
        yield Progress(0.0)
        return solution


def test_sizes_at_which_the_coarser_grid_leaves_many_folds_are_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    mapping, w, linear = folding(FINE, 70)
    small = placed(mapping, linear, linear.alpha * 0.8, linear.t)
    monkeypatch.setattr(own_sizes, "_cleared", lambda *_: pytest.fail("a hopeless size has been tried"))
    assert run(bisected(mapping, w, small, Hopeless(mapping, w))) is small
