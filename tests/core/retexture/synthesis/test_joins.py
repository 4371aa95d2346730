"""Where regrown texture meets the plain deformation, and the coordinates of one curve those of another."""

import numpy as np
import pytest

from core.arrays import Points
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.curves.fitting import fit
from core.progress import run
from core.retexture import job
from core.retexture.job import Settings, deform, retexture
from core.retexture.region import share_along
from core.retexture.result import plain_place
from core.retexture.source_outside_frame import far_outside
from core.retexture.synthesis.candidate_pool import Bounds, gather_candidates
from core.retexture.synthesis.patches import PatchShape, grow
from core.retexture.synthesis.placement import along_curves
from core.retexture.synthesis.scene import RetextureScene, prepare
from tests.core.retexture.retexture_scenes import HEIGHT, WIDTH, arched, bent, straight

SHAPE = (HEIGHT, WIDTH)
PATCH = PatchShape()


def scene_of(curves: list[FeatureCurve], reach_px: float) -> RetextureScene:
    """Return the scene of curves over noise, which has detail everywhere."""
    noise = np.random.default_rng(0).random((*SHAPE, 3)).astype(np.float32)
    return prepare(curves, deform(SHAPE, curves, None), noise, PATCH, reach_px, None)


def upright(x: float, top: float, bottom: float) -> Points:
    y = np.arange(top, bottom)
    return np.column_stack([np.full(len(y), x), y])


def test_nothing_is_shown_twice_where_the_region_ends() -> None:
    """Below the arch the curve's own coordinates and the deformation lead to places far apart."""
    scene = scene_of([FeatureCurve(straight(), arched(40, 120))], 60.0)
    steps = np.diff(scene.way.origins(upright(WIDTH / 2, 84, 190)).source[:, 1])
    assert steps.min() > 0.05
    assert steps.max() < 1.2


def test_between_two_curves_places_go_over_from_one_to_the_other() -> None:
    lifted, still = FeatureCurve(straight(90.0), straight(50.0)), FeatureCurve(straight(130.0), straight(130.0))
    scene = scene_of([lifted, still], 60.0)
    down = scene.way.origins(upright(WIDTH / 2, 52, 129)).source[:, 1]
    assert (np.abs(np.diff(down)) < 3).all()
    assert down[0] < 95
    assert down[-1] > 125


def test_inside_a_bend_places_go_over_from_one_side_to_the_other() -> None:
    """Where the ribs meet, what corresponds along the curve jumps by dozens of pixels."""
    scene = scene_of([FeatureCurve(straight(), arched(60, 120))], 80.0)
    for y in (110.0, 120.0, 130.0, 140.0):
        across = upright(y, 60, WIDTH - 60)[:, ::-1]
        steps = np.diff(scene.way.origins(across).source, axis=0)
        assert np.linalg.norm(steps, axis=1).max() < 4


def test_what_lies_on_a_curve_stays_on_it_however_tightly_that_bends() -> None:
    x = np.array([0, 60, 85, 98, 110, 122, 135, 160, 219.0])
    kinked = fit(np.column_stack([x, 120 - 45 * np.exp(-(((x - 110) / 14) ** 2))]), tolerance=0.2)
    curve = FeatureCurve(straight(), kinked)
    scene = scene_of([curve], 60.0)
    beside = scene.way.target.points[40:-40:8] + [[0.0, 5.0]]
    origins = scene.way.origins(beside)
    np.testing.assert_allclose(origins.source[:, 1] - 100, origins.offset, atol=0.1)


def test_the_deformation_counts_sooner_where_it_stretches_mildly() -> None:
    far, ones = np.array([0.0, 0.6, 0.9, 1.3, 2.1], np.float32), np.ones(5, np.float32)
    mild, wild = share_along(far, 0.3 * ones, ones), share_along(far, 1.2 * ones, ones)
    np.testing.assert_array_equal(mild[[0, 1, 4]], [1, 1, 0])
    np.testing.assert_array_equal(wild[[0, 1, 2, 4]], [1, 1, 1, 0])
    assert (mild[2:4] < wild[2:4]).all()
    creased = np.zeros(5, np.float32)
    assert share_along(far, 0.3 * ones, creased).max() == 0
    np.testing.assert_array_equal(share_along(far, 1.2 * ones, creased), wild)


def test_where_the_curve_leads_out_of_the_picture_the_deformation_has_its_place() -> None:
    scene = scene_of([FeatureCurve(straight(180.0), straight(150.0))], 60.0)
    down = scene.way.origins(upright(WIDTH / 2, 151, HEIGHT - 1)).source[:, 1]
    assert np.diff(down).min() > -0.3
    assert down.max() < HEIGHT - 0.5


def sloping(rise: float) -> Curve:
    """Return a line that falls to near the lower right corner, its end raised by so many px."""
    return Curve(np.column_stack([np.linspace(5, WIDTH - 6, 7), np.linspace(40, HEIGHT - 15 - rise, 7)]))


def test_where_much_of_the_source_lies_outside_the_picture_another_part_of_the_curve_stands_for_it() -> None:
    scene = scene_of([FeatureCurve(sloping(0), sloping(50))], 60.0)
    places = np.argwhere(scene.way.missing & (scene.area.nearness > 0.6))[::5, ::-1].astype(float)
    origins = scene.way.origins(places)
    outside = along_curves(scene.way.source, scene.way.target, places)[1][:, 1] > HEIGHT - 1
    assert outside.sum() > 10
    source = origins.source[outside]
    np.testing.assert_allclose(scene.way.source.feet(source).offset, origins.offset[outside], atol=0.5)
    room = np.minimum(PATCH.rib, HEIGHT - 1 - places[outside, 1])
    assert (HEIGHT - 1 - source[:, 1] >= room - 1e-6).all()


def test_parts_that_lead_far_outside_are_whole_and_shallow_ones_are_left() -> None:
    places = np.stack(np.meshgrid(10.0 * np.arange(20), 10.0 * np.arange(20)), axis=-1)
    places[2:5, 0, 0], places[3, 0, 0] = -5, -2 * PATCH.rib - 1
    places[19, 12:15, 1] = 200 + PATCH.rib
    far = far_outside(places, (200, 200), PATCH.rib)
    np.testing.assert_array_equal(np.argwhere(far), [[2, 0], [3, 0], [4, 0]])


def test_patches_end_where_the_deformation_has_it() -> None:
    scene = scene_of(bent(), 60.0)
    inside = np.argwhere((scene.way.inner > 0.3) & (scene.way.inner < 0.9))[::97, ::-1].astype(float)
    batch = grow(scene.way.origins(inside), PATCH, scene.fields, scene.way)
    across, along = PATCH.search_across, PATCH.search_along
    shown = batch.source[:, across:-across, along:-along].reshape(-1, 2)
    target = batch.target.reshape(-1, 2).astype(float)
    plain = target + scene.way.grid.at(scene.way.displacement, target)
    x, y = np.clip(np.rint(target), 0, [WIDTH - 1, HEIGHT - 1]).astype(int).T
    outer = scene.way.inner[y, x] == 0
    assert outer.sum() > 200
    assert np.linalg.norm(shown - plain, axis=1)[outer].max() < 1


def test_a_batch_whose_patches_may_show_nothing_has_no_rounds() -> None:
    scene = scene_of(bent(), 60.0)
    batch = grow(scene.way.origins(upright(WIDTH / 2, 84, 90)), PATCH, scene.fields, scene.way)
    picture, nowhere = np.zeros((*SHAPE, 3), np.float32), np.zeros(SHAPE, bool)
    assert gather_candidates(batch, picture, Bounds(nowhere, scene.area.free)).rounds == []


def test_candidates_are_free_inside_and_held_at_the_edge() -> None:
    scene = scene_of(bent(), 60.0)
    deep = scene.area.inner >= 1
    assert scene.area.free[deep].min() < 0.7
    assert scene.area.free.max() == 1
    held = np.argwhere((scene.area.inner == 0) & scene.area.may)[::50, ::-1].astype(float)
    assert scene.way.origins(held).free.max() == 0


def test_whatever_was_chosen_patches_meet_the_deformation_at_the_edge(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(job, "retract", lambda *_: None)
    noise = np.random.default_rng(0).integers(0, 256, (*SHAPE, 3)).astype(np.uint8)
    found = run(retexture(noise, bent(), Settings(PATCH, reach_px=60.0)))
    plain = plain_place(found.grid, found.field, (slice(0, HEIGHT), slice(0, WIDTH)))
    edge = (scene_of(bent(), 60.0).area.inner == 0) & (found.label > 0)
    assert edge.sum() > 200
    assert np.linalg.norm(found.place - plain, axis=-1)[edge].max() < 1


def test_patches_are_not_stretched_where_they_go_back_to_the_deformation() -> None:
    """A narrow region leaves little room for that."""
    noise = np.random.default_rng(0).integers(0, 256, (*SHAPE, 3)).astype(np.uint8)
    found = run(retexture(noise, bent(), Settings(PATCH, reach_px=25.0)))
    here, right, down = np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, :-1]
    label, place = found.label, found.place
    whole = (label[here] > 0) & (label[right] == label[here]) & (label[down] == label[here])
    steps = np.stack([place[right] - place[here], place[down] - place[here]], axis=-1)[whole]
    least = np.linalg.svd(steps, compute_uv=False)[:, 1]
    assert (least < 0.4).mean() < 0.02
