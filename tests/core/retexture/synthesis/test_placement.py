"""Where patches are laid, in which order, and of which size."""

from dataclasses import replace

import numpy as np
import pytest

from core.curves.feature_curves import FeatureCurve
from core.retexture.deformation.coordinates import SpineCurves
from core.retexture.deformation.diffusion import compression
from core.retexture.job import deform
from core.retexture.synthesis.patches import Patches, PatchShape
from core.retexture.synthesis.placement import PatchGrid, gap_places, order_origins, pace
from core.retexture.synthesis.scene import prepare
from tests.core.retexture.retexture_scenes import HEIGHT, WIDTH, bent, straight

SHAPE = (HEIGHT, WIDTH)


def test_the_pace_is_how_fast_the_source_goes_by() -> None:
    short, long = SpineCurves([straight(60.0, left=80)]), SpineCurves([straight(100.0)])
    places = np.array([[90.0, 100.0], [110.0, 120.0], [130.0, 80.0]])
    slow, fast = short.curves[0].length, long.curves[0].length
    np.testing.assert_allclose(pace(short, long, long.feet(places)), slow / fast, atol=1e-6)
    np.testing.assert_allclose(pace(long, short, short.feet(places)), fast / slow, atol=1e-6)


@pytest.mark.parametrize("count", [0, 1, 30, 400])
def test_batches_hold_all_patches_of_a_scale_in_order_and_the_first_few_of_them(count: int) -> None:
    curves = bent()
    scene = prepare(
        curves, deform(SHAPE, curves, None), np.zeros((HEIGHT, WIDTH, 3), np.float32), PatchShape(), 60.0, None
    )
    origins = scene.way.origins(np.random.default_rng(0).uniform(20, 180, (count, 2)))
    origins = origins.taken(np.argsort(origins.scale, kind="stable"))
    parts = list(Patches(origins, PatchShape(), scene.fields, scene.way).parts)
    np.testing.assert_array_equal(np.concatenate([[], *(np.arange(count)[part] for part in parts)]), np.arange(count))
    sizes = [part.stop - part.start for part in parts]
    assert all(sizes)
    assert all(np.ptp(origins.scale[part]) == 0 for part in parts)
    assert count < 400 or len(np.unique(origins.scale)) == 2
    assert count < 400 or sizes[0] == max(sizes) // 4


def test_smaller_patches_cover_the_middle_of_whole_ones_and_are_searched_for_as_far() -> None:
    curves, shape = bent(), PatchShape()
    picture = np.random.default_rng(0).random((HEIGHT, WIDTH, 3)).astype(np.float32)
    scene = prepare(curves, deform(SHAPE, curves, None), picture, shape, 60.0, None)
    origins = scene.way.origins(np.tile([[110.0, 150.0]], (3, 1)))
    patches = Patches(replace(origins, scale=np.array([1.0, 2.0, 3.0])), shape, scene.fields, scene.way)
    whole, half, third = (patches.batch(slice(i, i + 1)) for i in range(3))
    for part, scale in ((half, 2), (third, 3)):
        assert np.isin(part.covered.pixel, whole.covered.pixel).all()
        assert len(part.covered.pixel) == pytest.approx(len(whole.covered.pixel) / scale**2, rel=0.3)
        assert part.shape.search_along == shape.search_along
        middle = part.shape.rib, part.shape.spine
        np.testing.assert_allclose(part.target[0][middle], origins.target[0], atol=1e-3)


def test_patches_keep_their_size_beside_a_curve_that_only_bends() -> None:
    curves = bent()
    plain = deform(SHAPE, curves, None)
    picture = np.random.default_rng(0).random((HEIGHT, WIDTH, 3)).astype(np.float32)
    scene = prepare(curves, plain, picture, PatchShape(), 60.0, None)
    beside = scene.area.nearness > 0.99
    assert beside.sum() > 500
    dense = plain.grid.at_pixels(scene.way.compression[..., None])[..., 0]
    assert dense[beside].max() < 1.2
    assert plain.grid.at_pixels(compression(plain.grid, plain.field)[..., None])[..., 0][beside].max() > 1.5


def test_gaps_are_covered_by_one_place_in_each_square() -> None:
    bare = np.zeros((40, 40), bool)
    bare[3:6, 3:30] = True
    places = gap_places(bare, 10)
    assert len(places) == 3
    x, y = places.astype(int).T
    assert bare[y, x].all()
    assert PatchGrid(10, 5).shift == 0


def test_rows_are_laid_from_the_curve_outwards_and_from_their_ends() -> None:
    curves = [FeatureCurve(straight(80.0), straight(100.0))]
    picture = np.random.default_rng(0).random((HEIGHT, WIDTH, 3)).astype(np.float32)
    scene = prepare(curves, deform(SHAPE, curves, None), picture, PatchShape(), 60.0, None)
    lattice = PatchGrid((WIDTH - 1) / 10, 10)
    origins = order_origins(scene.way, scene.area.must, lattice)
    whole = origins.taken(origins.scale == 1)
    row = np.rint(np.abs(whole.offset) / lattice.across)
    step = np.rint(np.minimum(whole.target[:, 0], WIDTH - 1 - whole.target[:, 0]) / lattice.along)
    assert row.max() >= 3
    assert step.max() >= 3
    order = 2 * row + step
    assert (np.diff(order) >= 0).all()
    assert (np.diff(row)[np.diff(order) == 0] >= 0).all()
