"""The parts of retexturing, each against what its definition says."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from core.arrays import Points, Singles
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.retexture.deformation import coordinates
from core.retexture.deformation.coordinates import DirectionField, SpineCurves, trace, traced
from core.retexture.deformation.diffusion import Diffusion, compression, deformation, distortion
from core.retexture.deformation.grids import fill, locate
from core.retexture.job import deform
from core.retexture.sampling import Kernel, read
from core.retexture.synthesis.candidate_choice import STRETCH, Pool, costs, drift
from core.retexture.synthesis.candidate_pool import rounds
from core.retexture.synthesis.patches import Covered, Patches, PatchShape
from core.retexture.synthesis.placement import PatchGrid, gap_places, ordered_origins, pace
from core.retexture.synthesis.scene import near_curves, prepare
from tests.core.retexture.retexture_scenes import HEIGHT, WIDTH, arched, bent, straight

SHAPE = (HEIGHT, WIDTH)


def ring(radius: float, centre: tuple[float, float]) -> Curve:
    """Return a circle of four segments, to a thousandth of its radius."""
    k = 0.5522847498 * radius
    r = radius
    points = [(r, 0), (r, k), (k, r), (0, r), (-k, r), (-r, k), (-r, 0), (-r, -k), (-k, -r), (0, -r), (k, -r), (r, -k)]
    return Curve(np.array([*points, points[0]], float) + centre, closed=True)


# Deformation


def test_the_deformation_leads_from_the_target_curve_to_the_source_curve() -> None:
    grid, field = deformation(SHAPE, bent())
    t = np.linspace(0.8, straight().segments - 0.8, 50)
    target, source = bent()[0].target, bent()[0].source
    assert target is not None
    same = target.segments == source.segments
    s = t if same else source.parameter_at(target.length_at(t) / target.length * source.length)
    t = t if same else target.parameter_at(source.length_at(s) / source.length * target.length)
    np.testing.assert_allclose(target.at(t) + grid.at(field, target.at(t)), source.at(s), atol=0.3)


def test_the_deformation_is_harmonic_and_rests_at_the_border() -> None:
    grid, field = deformation(SHAPE, bent())
    assert not field[0].any()
    assert not field[-1].any()
    assert not field[:, 0].any()
    inner = field[1:-1, 1:-1]
    mean = (field[2:, 1:-1] + field[:-2, 1:-1] + field[1:-1, 2:] + field[1:-1, :-2]) / 4
    away = (
        SpineCurves([arched()]).distance(grid.nodes[1:-1, 1:-1].reshape(-1, 2)).reshape(inner.shape[:2]) > 2 * grid.step
    )
    np.testing.assert_allclose(inner[away], mean[away], atol=1e-9)


def test_nothing_moves_beyond_the_chosen_distance() -> None:
    grid, field = deformation(SHAPE, bent(), reach_px=30)
    far = SpineCurves([arched()]).distance(grid.nodes.reshape(-1, 2)).reshape(grid.rows, grid.columns) > 31
    assert not field[far].any()
    assert np.abs(field).max() > 20


def test_fields_are_read_the_same_everywhere() -> None:
    grid = Diffusion(SHAPE, np.array([[50.0, 50.0]]))
    linear = grid.nodes * [0.3, -2] + 1
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    want = np.stack([x * 0.3 + 1, y * -2.0 + 1], axis=-1)
    np.testing.assert_allclose(grid.at_pixels(linear), want, atol=1e-3)
    np.testing.assert_allclose(grid.at_pixels(linear, (slice(9, 30), slice(4, 99))), want[9:30, 4:99], atol=1e-3)
    np.testing.assert_allclose(grid.at(linear, np.array([[7.0, 3.0]])), want[3:4, 7], atol=1e-9)


def test_compression_is_clamped_and_distortion_is_that_of_the_map() -> None:
    grid = Diffusion(SHAPE, np.array([[50.0, 50.0]]))
    assert compression(grid, np.zeros((grid.rows, grid.columns, 2))) == pytest.approx(1)
    np.testing.assert_allclose(compression(grid, grid.nodes * [1.0, 0]), 2, atol=1e-9)
    np.testing.assert_allclose(compression(grid, grid.nodes * [9.0, 0]), 3)
    np.testing.assert_allclose(compression(grid, grid.nodes * [-0.6, 0]), 1, atol=1e-9)
    turned = grid.nodes @ np.array([[0.0, 1.0], [-1.0, 0.0]]) - grid.nodes
    np.testing.assert_allclose(compression(grid, turned), 1, atol=1e-9)
    np.testing.assert_allclose(distortion(grid, turned), 0, atol=1e-9)
    np.testing.assert_allclose(distortion(grid, grid.nodes * [1.0, 0]), np.log(2), atol=1e-9)


# Curvilinear coordinates


def test_feet_are_nearest_points_with_a_side() -> None:
    feet = SpineCurves([straight(100.0), straight(20.0)]).feet(np.array([[50.0, 110.0], [50.0, 90.0], [70.0, 25.0]]))
    np.testing.assert_array_equal(feet.curve, [0, 0, 1])
    np.testing.assert_allclose(feet.offset, [10, -10, 5], atol=1e-9)
    np.testing.assert_allclose(feet.length, [50, 50, 70], atol=1e-6)
    assert SpineCurves([straight(left=50)]).feet(np.array([[40.0, 100.0]])).beyond.all()


@settings(max_examples=25)
@given(st.floats(40, 60), st.floats(-15, 15), st.floats(0, 6.28))
@example(40.0, -15.0, 0.789)
def test_on_a_circle_spines_are_arcs_and_ribs_radii(radius: float, offset: float, angle: float) -> None:
    centre = np.array([110.0, 100.0])
    curves = SpineCurves([ring(radius, (110, 100))])
    field = DirectionField(curves, (0, 0, WIDTH, HEIGHT))
    r = radius + offset
    outward = np.array([np.cos(angle), np.sin(angle)])
    heading = np.array([-outward[1], outward[0]])
    grid = trace(field, (centre + r * outward)[None], heading[None], spine=10, rib=5)[0]
    distance = np.linalg.norm(grid - centre, axis=-1)
    # The circle runs clockwise on screen, so that its normal points inwards.
    want = r - np.arange(-5, 6)[:, None] + 0 * distance
    np.testing.assert_allclose(distance, want, atol=0.15)
    along = np.linalg.norm(np.diff(grid[5], axis=0), axis=-1)
    np.testing.assert_allclose(along, 1, atol=0.01)


def test_a_grid_that_would_fold_is_smoothed(monkeypatch: pytest.MonkeyPatch) -> None:
    curves = SpineCurves([ring(12, (110, 100))])
    field = DirectionField(curves, (0, 0, WIDTH, HEIGHT))
    origin, heading = np.array([[122.0, 100.0]]), np.array([[0.0, 1.0]])

    def folds(smoothing: float) -> int:
        monkeypatch.setattr(coordinates, "SMOOTHING", smoothing)
        grid = trace(field, origin, heading, spine=8, rib=16)
        assert np.linalg.norm(grid - origin, axis=-1).max() < 30
        along, across = np.diff(grid[0], axis=1)[:-1], np.diff(grid[0], axis=0)[:, :-1]
        return int((along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0] <= 0).sum())

    assert coordinates.SMOOTHING == 0.7
    assert folds(0.7) < 0.7 * folds(0.0)


def test_patches_stop_two_pixels_short_of_another_curve() -> None:
    kept = near_curves(SpineCurves([straight(60.0), straight(100.0)]), SHAPE)
    np.testing.assert_array_equal(np.flatnonzero(kept[:, 110] == 0), np.arange(58, 63))
    np.testing.assert_array_equal(np.flatnonzero(kept[:, 110] == 1), np.arange(98, 103))


def test_traces_keep_their_sense_between_curves_of_opposite_sense() -> None:
    curves = SpineCurves([straight(80.0), straight(120.0).reversed()])
    field = DirectionField(curves, (0, 0, WIDTH, HEIGHT))
    grid = trace(field, np.array([[100.0, 100.0]]), np.array([[1.0, 0.0]]), spine=10, rib=10)[0]
    np.testing.assert_allclose(grid[10], np.column_stack([np.arange(90, 111), np.full(21, 100)]), atol=1e-3)
    np.testing.assert_allclose(grid[:, 10], np.column_stack([np.full(21, 100), np.arange(90, 111)]), atol=1e-3)


def test_pixels_find_their_place_in_a_bent_grid() -> None:
    curves = SpineCurves([arched()])
    field = DirectionField(curves, (0, 0, WIDTH, HEIGHT))
    place, tangent = curves.place(np.zeros(1, int), np.array([100.0]), np.array([12.0]))
    rough = traced(field, place, tangent, spine=20, rib=12)
    grid = fill(rough, spine=20, rib=12)[0]
    corner = np.rint(place[0]).astype(int) - 26
    # Of two windows the second lies where only a part of the grid reaches.
    corners = np.stack([corner, corner + 30])
    number, pixel, at = locate(np.concatenate([rough, rough]), corners, 53, spine=20, rib=12)
    np.testing.assert_array_equal(number, np.sort(number))
    inside = (at > 0).all(axis=-1) & (at < [40, 24]).all(axis=-1)
    assert (inside & (number == 0)).sum() > 800
    assert 50 < (number == 1).sum() < 500
    pixel = np.stack([pixel % 53, pixel // 53], axis=-1) + corners[number]
    np.testing.assert_allclose(read(grid, at[inside][:, None])[:, 0], pixel[inside], atol=0.2)
    assert len(np.unique(pixel[number == 0], axis=0)) == (number == 0).sum()


# Layout and choice


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
    origins = ordered_origins(scene.way, scene.area.must, lattice)
    whole = origins.taken(origins.scale == 1)
    row = np.rint(np.abs(whole.offset) / lattice.across)
    step = np.rint(np.minimum(whole.target[:, 0], WIDTH - 1 - whole.target[:, 0]) / lattice.along)
    assert row.max() >= 3
    assert step.max() >= 3
    order = 2 * row + step
    assert (np.diff(order) >= 0).all()
    assert (np.diff(row)[np.diff(order) == 0] >= 0).all()


def pool(colours: Singles, uses: Singles | None = None, unusable: Singles | None = None) -> Pool:
    """Return what is known of candidates with `colours` (n, K', J', c)."""
    flat = np.zeros(colours.shape[:3], np.float32)
    return Pool(
        np.concatenate([colours, (colours**2).sum(axis=-1, keepdims=True)], axis=-1),
        flat if uses is None else uses,
        flat if unusable is None else unusable,
        np.full(len(colours), colours.var() + 1e-4),
    )


def test_the_candidate_that_continues_what_is_shown_costs_nothing() -> None:
    colours = np.random.default_rng(0).random((2, 15, 31, 3)).astype(np.float32)
    shown = np.stack([colours[0, 3:10, 8:29], colours[1, 2:9, 4:25]])
    whole = np.ones((2, 7, 21), np.float32)
    cost = costs(pool(colours), shown, whole, whole, 0.3)
    assert cost.shape == (2, 9, 11)
    assert divmod(int(cost[0].argmin()), 11) == (3, 8)
    assert divmod(int(cost[1].argmin()), 11) == (2, 4)
    np.testing.assert_allclose(cost.min(axis=(1, 2)), 0, atol=1e-4)


def test_candidates_cost_what_their_colours_differ() -> None:
    rng = np.random.default_rng(1)
    colours, shown = (rng.random((1, *size, 3)).astype(np.float32) for size in ((15, 31), (7, 21)))
    weight = rng.random((1, 7, 21)).astype(np.float32)
    known = pool(colours)
    cost = costs(known, shown, weight, np.ones_like(weight), 0.0)[0]
    for k, j in ((0, 0), (8, 10), (3, 7)):
        gap = ((shown[0] - colours[0, k : k + 7, j : j + 21]) ** 2).sum(axis=-1)
        expected = (weight[0] ** 2 * gap).sum() / ((weight[0] ** 2).sum() * known.variance[0])
        np.testing.assert_allclose(cost[k, j], expected, rtol=1e-4)


def test_used_and_forbidden_places_cost_more() -> None:
    even = np.zeros((1, 15, 31, 3), np.float32)
    whole = np.ones((1, 7, 21), np.float32)
    left = np.zeros((1, 15, 31), np.float32)
    left[..., :12] = 1
    for which in ({"uses": left}, {"unusable": left}):
        cost = costs(pool(even + np.float32(0.5), **which), even[:, :7, :21], whole, whole, 0.5)[0]
        assert (np.diff(cost[4]) < 1e-6).all()
        assert cost[4, 0] > cost[4, -1] + 0.1


def test_a_patch_on_the_curve_keeps_its_distance() -> None:
    shape = PatchShape()
    offset = np.array([0.0, shape.rib + 2.0, -shape.rib - 2.0, 40.0])
    on, inside, outside, far = drift(shape, offset, np.ones(4), np.zeros(4))[:, :, shape.search_along]
    assert (on < 100).sum() == 1
    assert (np.flatnonzero(inside < 100) >= shape.search_across - 1).all()
    np.testing.assert_array_equal(outside, inside[::-1])
    assert (far < 100).all()


def test_candidates_cost_what_they_are_stretched_on_their_way_back() -> None:
    shape = PatchShape()
    flat, steep = drift(shape, np.full(2, 40.0), np.ones(2), np.array([0.0, 0.05]))
    across, along = np.indices(flat.shape) - np.array([[[shape.search_across]], [[shape.search_along]]])
    np.testing.assert_allclose(steep - flat, STRETCH * 0.05**2 * (along**2 + across**2))


def test_patches_of_a_round_do_not_touch_and_wait_for_earlier_ones() -> None:
    squares = [(2, 2), (12, 2), (6, 2), (5, 5), (13, 12)]
    pixel = np.concatenate([((np.arange(4) + y)[:, None] * 20 + np.arange(4) + x).ravel() for x, y in squares])
    patch = np.repeat([0, 1, 2, 3, 5], 16)
    found = rounds(Covered(patch, pixel, np.zeros((80, 2), np.float32)), 6, (20, 20))
    # The third lies beside the first, and the fourth over both.
    assert [which.tolist() for which in found] == [[0, 1, 5], [2], [3]]


@pytest.mark.parametrize("kernel", list(Kernel))
def test_reading_at_pixels_returns_them(kernel: Kernel) -> None:
    picture = np.random.default_rng(1).random((30, 40, 3)).astype(np.float32)
    y, x = np.mgrid[5:20, 5:30]
    at: Points = np.stack([x, y], axis=-1).astype(np.float64)
    np.testing.assert_allclose(read(picture, at, kernel), picture[5:20, 5:30], atol=1e-5)
    np.testing.assert_allclose(
        read(picture, at.reshape(1, 1, -1, 2), kernel)[0, 0], picture[5:20, 5:30].reshape(-1, 3), atol=1e-5
    )
    assert read(picture, np.empty((0, 2)), kernel).shape == (0, 3)
