"""The lattice of large texels from votes of alike patches."""

import numpy as np
import pytest
import scipy

from core.overlay.decomposition import decompose
from core.overlay.detection import alike_patches
from core.overlay.detection.alike_patches import find_alike_patches
from core.overlay.detection.displacement_votes import Pairs, count_votes, find_bases
from core.overlay.detection.seeding import NoPatternError
from core.overlay.search.finding import find_print
from core.overlay.search.large_periods import LARGE_PX, find_likely, find_likely_of_patches
from core.progress import run
from tests.core.overlay.overlay_scenes import Scene, make_scene
from tests.core.overlay.prints import canvas_of, displaced_px, find_likeliest, painted, sett

BASIS = np.array([[93.0, 6.0], [-5.0, 88.0]])


@pytest.fixture(scope="module")
def plaid() -> Scene:
    return make_scene(sett(), size=(330, 300), basis=BASIS, bend=4.0, noise=0.03)


def pairs_of(scene: Scene) -> Pairs:
    return find_alike_patches(canvas_of(scene.photo).image, np.ones(scene.photo.shape[:2], bool), LARGE_PX)


def texels_off(scene: Scene, pairs: Pairs) -> np.ndarray:
    """Return how far (m,) from whole numbers of texels the places of pairs lie apart."""
    at = pairs.points.T[::-1]
    uv = np.stack([scipy.ndimage.map_coordinates(plane, at, order=1) for plane in np.moveaxis(scene.uv, -1, 0)], -1)
    apart = uv[pairs.second] - uv[pairs.first]
    return np.asarray(np.abs(apart - np.rint(apart)).max(-1))


def test_patches_of_a_bent_plaid_are_alike_where_they_lie_whole_texels_apart(plaid: Scene) -> None:
    pairs = pairs_of(plaid)
    assert len(pairs.first) > 2000
    assert np.median(texels_off(plaid, pairs)) < 0.011
    assert np.linalg.norm(pairs.vectors, axis=1).min() > LARGE_PX


def test_votes_of_patches_tell_a_plaid_that_those_of_keypoints_are_less_sure_of(plaid: Scene) -> None:
    (sure, basis), *_ = find_likely_of_patches(canvas_of(plaid.photo))[1]
    steps = np.linalg.solve(BASIS, basis)
    assert np.abs(steps - np.rint(steps)).max() < 0.1
    assert sure > max((other for other, _ in find_likely(canvas_of(plaid.photo))[1]), default=0.0)


def test_a_plaid_is_laid_by_its_patches(plaid: Scene) -> None:
    cloth, found, _ = find_likeliest(plaid.photo, painted(plaid.photo), alike="patches")
    assert found.cells.mean() > 0.9
    assert np.percentile(displaced_px(plaid, cloth, found.pieces[0]), 90) < 2.0


def test_crumpled_cloth_of_smaller_texels_is_laid_by_its_patches() -> None:
    scene = make_scene(sett(), size=(260, 240), basis=np.array([[44.0, 3.0], [-2.0, 40.0]]), bend=5.0)
    found, *_ = run(find_print(scene.photo, painted(scene.photo), 0, alike="patches"))
    piece = found.followed.pieces[0]
    assert piece.cells.mean() > 0.8
    assert np.percentile(displaced_px(scene, found.cloth, piece), 90) < 1.0


def test_nothing_is_found_in_thin_lines_that_are_painted(plaid: Scene) -> None:
    lines = np.zeros(plaid.photo.shape[:2], bool)
    lines[::7] = lines[1::7] = True
    with pytest.raises(NoPatternError):
        run(decompose(plaid.photo, region=lines))


def test_a_larger_photo_is_compared_when_it_is_shrunk(plaid: Scene) -> None:
    times = 4
    large = np.repeat(np.repeat(canvas_of(plaid.photo).image, times, 0), times, 1)
    pairs = find_alike_patches(large, np.ones(large.shape[:2], bool), times * LARGE_PX)
    assert len(np.unique(pairs.first)) < plaid.shading.size
    (_, basis), *_ = find_bases(count_votes(pairs, times * LARGE_PX))
    steps = np.linalg.solve(times * BASIS, basis)
    assert np.abs(steps - np.rint(steps)).max() < 0.1


@pytest.mark.parametrize("most", [100, 500])
def test_of_much_cloth_evenly_spaced_patches_are_looked_for_and_they_tell_it(
    plaid: Scene, monkeypatch: pytest.MonkeyPatch, most: int
) -> None:
    monkeypatch.setattr(alike_patches, "MOST_ASKED", most)
    pairs = pairs_of(plaid)
    assert most / 2 < len(np.unique(pairs.first)) <= most
    (_, basis), *_ = find_bases(count_votes(pairs, LARGE_PX))
    steps = np.linalg.solve(BASIS, basis)
    assert np.abs(steps - np.rint(steps)).max() < 0.1


def test_only_patches_in_the_region_are_compared(plaid: Scene) -> None:
    valid = np.zeros(plaid.photo.shape[:2], bool)
    valid[60:300, 40:280] = True
    pairs = find_alike_patches(canvas_of(plaid.photo).image, valid, LARGE_PX)
    half = 2 * (alike_patches.SIDE // 2)
    seen = pairs.points[np.concatenate([pairs.first, pairs.second])]
    assert len(seen)
    assert (seen.min(0) >= [40 + half - 2, 60 + half - 2]).all()
    assert (seen.max(0) <= [280 - half + 2, 300 - half + 2]).all()


@pytest.mark.parametrize("deviation", [0.0, 0.005, 0.1])
def test_even_cloth_and_noise_have_no_alike_patches(deviation: float) -> None:
    image = 0.5 + deviation * np.random.default_rng(0).standard_normal((220, 200, 3)).astype(np.float32)
    assert not len(find_alike_patches(image.astype(np.float32), np.ones((220, 200), bool), LARGE_PX).first)
    assert not len(find_alike_patches(image.astype(np.float32), np.zeros((220, 200), bool), LARGE_PX).first)
