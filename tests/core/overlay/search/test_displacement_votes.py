"""The lattice of large texels from votes of alike keypoints."""

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.detection.displacement_votes import (
    Pairs,
    count_votes,
    find_alike,
    find_bases,
    first_of_each,
)
from core.overlay.filters import magnifying
from core.overlay.search import large_periods
from core.overlay.search.large_periods import LARGE_PX, find_likely
from tests.core.overlay.overlay_scenes import Scene, make_scene
from tests.core.overlay.prints import PRINT, canvas_of, print_of_blots, strokes


def test_motifs_of_few_pixels_are_told_in_an_enlarged_photo(monkeypatch: pytest.MonkeyPatch) -> None:
    basis = np.array([[50.0, -2.0], [5.0, 50.0]])
    scene = make_scene(strokes(), size=(240, 220), basis=basis, bend=2.0, noise=0.02)
    sure: list[float] = []
    for longest in (10, 1000):
        monkeypatch.setattr(magnifying, "LONGEST_PX", longest)
        (votes, found), *_ = find_likely(canvas_of(scene.photo))[1]
        assert np.abs(found - basis).max() < 3
        sure.append(votes)
    assert sure[1] > 1.5 * sure[0]


def test_noise_of_an_enlarged_photo_repeats_nowhere() -> None:
    photo = 0.5 + 0.1 * np.random.default_rng(0).standard_normal((300, 280, 3))
    assert not find_likely(canvas_of(photo))[1]


def test_where_the_enlarged_photo_is_certain_of_nothing_its_own_pixels_tell(
    printed: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(large_periods, "SURE", 1e3)
    pairs, ((_, basis), *_) = find_likely(canvas_of(printed.photo))
    assert len(pairs.points) == len(pairs_of(printed.photo).points)
    steps = np.linalg.solve(printed.basis, basis)
    assert np.abs(steps - np.rint(steps)).max() < 0.05


def pairs_of(photo: Floats) -> Pairs:
    return find_alike(canvas_of(photo).image, np.ones(photo.shape[:2], bool), LARGE_PX)


@pytest.mark.parametrize("seed", range(3))
def test_votes_of_alike_keypoints_tell_vectors_that_fit_into_a_photo_twice(seed: int) -> None:
    scene = make_scene(print_of_blots(seed), size=(300, 280), basis=PRINT, bend=4.0)
    steps = np.linalg.solve(scene.basis, find_bases(count_votes(pairs_of(scene.photo), LARGE_PX))[0][1])
    assert np.abs(steps - np.rint(steps)).max() < 0.1
    assert abs(np.linalg.det(np.rint(steps))) == 1


def test_pairs_between_the_same_blocks_are_one_vote_that_of_the_first() -> None:
    rng = np.random.default_rng(3)
    points, (first, second) = rng.uniform(0, 100, (40, 2)), rng.integers(0, 40, (2, 300))
    block = rng.integers(0, 5, 40)
    kept = first_of_each(Pairs(points, first, second), block, 5)
    _, rows = np.unique(block[first] * 5 + block[second], return_index=True)
    assert np.array_equal(kept.first, first[rows])
    assert np.array_equal(kept.second, second[rows])
