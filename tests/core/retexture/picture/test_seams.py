"""Seams between patches: where they run, and how their steps are blended."""

import numpy as np
import pytest

from core.arrays import Bools, Ints, Singles
from core.linalg import poisson
from core.retexture.picture.poisson_blend import correction
from core.retexture.picture.seam_antialiasing import SHARE, across_seams
from core.retexture.sampling import read
from core.retexture.synthesis.graph_cut import BARE, GROWN, STEADY, GrownPicture
from core.retexture.synthesis.pixel_adjacency import find_adjacency


def empty_canvas(shown: Singles) -> GrownPicture:
    """Return a canvas that shows a picture (H, W, c), which patches may cover anywhere and must nowhere."""
    nothing = np.zeros(shown.shape[:2], bool)
    return GrownPicture(shown.copy(), np.zeros((*shown.shape[:2], 2), np.float32), must=nothing, may=~nothing)


def merge(canvas: GrownPicture, label: int, patch: Singles, reach: Bools, usable: Bools | None = None) -> int:
    """Merge a picture (H, W, c) into the canvas where it reaches, with (label, label) for its place everywhere.

    `usable` (H, W) is where it may be shown; None for everywhere.
    """
    pixel = np.flatnonzero(reach)
    labels = np.full(len(pixel), label)
    cover = find_adjacency(np.zeros(len(pixel), np.int64), pixel, reach.shape)
    place = np.full((len(pixel), 2), label, np.float32)
    return canvas.merge(
        cover, labels, patch[reach], place, np.ones(len(pixel), bool) if usable is None else usable[reach]
    )


def test_the_cut_takes_many_faint_steps_for_few_that_break() -> None:
    shown = np.zeros((20, 30, 3), np.float32)
    patch = np.ones((20, 30, 3), np.float32)
    patch[:, 12:14] = 0
    patch[8:12, 12:14] = 0.6
    patch[:, 16:18] = 0.16
    canvas = empty_canvas(shown)
    canvas.state[:, 25:] = BARE
    reach = np.ones((20, 30), bool)
    reach[:, :5] = False
    merge(canvas, 7, patch, reach)
    assert (canvas.label[:, 17:] == 7).all()
    assert not canvas.label[:, :17].any()


def test_only_what_a_patch_has_laid_counts_in_full_and_bare_pixels_do_not() -> None:
    shown = np.zeros((20, 30, 3), np.float32)
    must = np.zeros((20, 30), bool)
    must[:, 20:] = True
    canvas = GrownPicture(shown, np.zeros((20, 30, 2), np.float32), must=must, may=~np.zeros_like(must))
    reach = np.zeros((20, 30), bool)
    reach[:10, 18:26] = True
    merge(canvas, 7, shown + np.float32(0.5), reach)
    np.testing.assert_array_equal(canvas.state == GROWN, canvas.label == 7)
    x, y = np.meshgrid(np.arange(30, dtype=np.float32), np.arange(20, dtype=np.float32))
    weight = canvas.weigh_at(np.stack([x, y], axis=-1))
    np.testing.assert_array_equal(weight == 1, canvas.label == 7)
    np.testing.assert_array_equal(weight == 0, canvas.state == BARE)
    np.testing.assert_allclose(weight[:, :18], STEADY)
    assert (weight == 0).sum() == 20 * 10 - 10 * 6


def test_the_cut_runs_where_gradients_agree_too() -> None:
    """Off by as much at both pixels of a seam, the one with the same sign there is a shade, the other an edge."""
    shown = np.full((20, 30, 3), 0.5, np.float32)
    patch = shown + np.float32(0.5)
    patch[:, 11:13] = shown[:, 11:13] + np.float32(0.11)
    patch[:, 17] = shown[:, 17] + np.float32(0.1)
    patch[:, 18] = shown[:, 18] - np.float32(0.1)
    canvas = empty_canvas(shown)
    canvas.state[:, 25:] = BARE
    reach = np.ones((20, 30), bool)
    reach[:, :5] = False
    merge(canvas, 7, patch, reach)
    assert (canvas.label[:, 12:] == 7).all()
    assert not canvas.label[:, :12].any()


def test_the_cut_runs_where_both_pictures_agree() -> None:
    shown = np.zeros((20, 30, 3), np.float32)
    patch = np.ones((20, 30, 3), np.float32)
    patch[:, 12:14] = 0
    canvas = empty_canvas(shown)
    canvas.state[:, 20:] = BARE
    reach = np.ones((20, 30), bool)
    reach[:, :5] = False
    merge(canvas, 7, patch, reach)
    assert (canvas.label[:, 20:] == 7).all()
    assert not canvas.label[:, :12].any()
    assert not (canvas.state == BARE).any()
    assert canvas.seams.sum() == 0
    np.testing.assert_array_equal(canvas.colour[canvas.label == 7], patch[canvas.label == 7])


def test_a_patch_never_leaves_its_reach_and_mends_an_old_seam() -> None:
    shown = np.zeros((16, 16, 3), np.float32)
    shown[:, 8:] = 1
    canvas = GrownPicture(
        shown, np.zeros((16, 16, 2), np.float32), must=np.zeros((16, 16), bool), may=np.ones((16, 16), bool)
    )
    canvas.seams[0, :, 7] = 6
    ramp = np.broadcast_to(np.linspace(0, 1, 16, dtype=np.float32)[:, None], (16, 16, 3)).copy()
    reach = np.zeros((16, 16), bool)
    reach[2:14, 2:14] = True
    before = canvas.seams.sum()
    merge(canvas, 3, ramp, reach)
    assert not (canvas.label[~reach] > 0).any()
    assert canvas.seams.sum() <= before


def test_what_may_not_be_shown_is_not_shown_even_on_bare_pixels() -> None:
    canvas = empty_canvas(np.zeros((12, 18, 3), np.float32))
    canvas.state[:, 6:] = BARE
    usable = np.ones((12, 18), bool)
    usable[3:5, 9:12] = False
    taken = merge(canvas, 5, np.ones((12, 18, 3), np.float32), np.ones((12, 18), bool), usable)
    assert taken == (canvas.label == 5).sum()
    assert not canvas.label[~usable].any()
    assert (canvas.label[:, 6:][usable[:, 6:]] == 5).all()
    np.testing.assert_array_equal(np.argwhere(canvas.state == BARE), np.argwhere(~usable))


def test_a_step_is_taken_away_and_fades() -> None:
    right = np.zeros((40, 79, 1), np.float32)
    right[:, 39] = 1
    change = poisson.remove_steps(right, np.zeros((39, 80, 1), np.float32), fade_px=6)[..., 0]
    np.testing.assert_allclose(change[:, 40] - change[:, 39], -1, atol=0.1)
    np.testing.assert_allclose(change[:, [0, -1]], 0, atol=0.01)
    np.testing.assert_allclose(change[20], -change[20, ::-1], atol=1e-5)


def halves_of(step: float, noise: float, *, edge: bool = False) -> tuple[Singles, Singles, Ints]:
    """Return a source that is brighter by `step` from column 60 on, and two patches that meet at column 30.

    They show it from column 0 and from column 60 on; or, if it is an `edge` of the source, both from column 30 on.
    """
    source = np.random.default_rng(4).normal(0.5, noise, (60, 120, 3)).astype(np.float32)
    source[:, 60:] += np.float32(step)
    y, x = np.mgrid[:60, :60].astype(np.float32)
    beside = 30 if edge else np.where(x < 30, 0, 60)
    label = np.where(x < 30, 1, 2).astype(np.int64)
    return source, np.stack([x + beside, y], axis=-1).astype(np.float32), label


def shown(source: Singles, place: Singles, label: Ints) -> Singles:
    """Return what patches show, each pixel beside a seam mixed with what lies across it."""
    picture, mixture = read(source, place), across_seams(place, label)
    flat = picture.reshape(-1, 3)
    flat[mixture.pixel] += np.float32(SHARE) * (read(source, mixture.place) - flat[mixture.pixel])
    return picture


def test_an_even_step_between_patches_is_blended() -> None:
    halves = halves_of(0.08, 0.01)
    change = correction(*halves)
    assert change is not None
    columns = (shown(*halves) + change).mean(axis=(0, 2))
    assert np.abs(np.diff(columns[25:35])).max() < 0.012
    assert abs(columns[29] - columns[30]) < 0.012
    assert columns[55] - columns[5] > 0.06


@pytest.mark.parametrize(("step", "noise", "edge"), [(0.0, 0.1, False), (0.6, 0.01, False), (0.1, 0.01, True)])
def test_texture_other_things_and_edges_are_no_visible_seams(step: float, noise: float, edge: bool) -> None:
    change = correction(*halves_of(step, noise, edge=edge))
    assert change is None or np.abs(change).max() < 0.02


def test_a_step_that_changes_its_sign_along_the_seam_is_blended() -> None:
    source, place, label = halves_of(0.08, 0.01)
    source[30:, 60:] -= np.float32(0.16)
    change = correction(source, place, label)
    assert change is not None
    mended = shown(source, place, label) + change
    for rows in (slice(0, 20), slice(50, 60)):
        assert abs(mended[rows, 31].mean() - mended[rows, 28].mean()) < 0.03


def test_the_plain_deformation_is_not_touched_by_blending() -> None:
    source, place, label = halves_of(0.08, 0.01)
    label[label == 1] = 0
    change = correction(source, place, label)
    assert change is not None
    assert not change[:, :30].any()
    picture = shown(source, place, label)
    assert abs(float((picture + change)[:, 30].mean() - picture[:, 29].mean())) < 0.03


def test_beside_a_seam_the_neighbour_is_carried_on() -> None:
    x = np.broadcast_to(np.arange(12, dtype=np.float32), (6, 12))
    place = np.stack([np.where(x < 6, x, x + 100), np.zeros_like(x)], axis=-1)
    label = np.where(x < 6, 1, 2).astype(np.int64)
    mixture = across_seams(place, label)
    np.testing.assert_array_equal(np.unique(mixture.pixel % 12), [5, 6])
    at_five = mixture.place[mixture.pixel % 12 == 5]
    np.testing.assert_allclose(at_five[:, 0], 105)
    assert len(mixture.rows(2, 4, 12).pixel) == 4
