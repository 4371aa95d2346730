"""Stages that take cloth laid on a photo, as it was searched, to its own size and to the finished model."""

from dataclasses import replace

import numpy as np
import pytest

from core.arrays import Bools, Floats, Singles
from core.overlay.decomposition import decompose
from core.overlay.found_cloth import FoundCloth
from core.overlay.pixels.model import PixelModel, begin
from core.overlay.pixels.stages import draw_model, enlarge, light_folds
from core.progress import run
from tests.core.overlay.overlay_scenes import make_scene, motif

TIMES = 3
Y, X = np.indices((170, 190)).astype(float)
LARGE_Y, LARGE_X = (np.indices((170 * TIMES - 1, 190 * TIMES - 2)) + 0.5) / TIMES - 0.5
EVERYWHERE = np.ones(X.shape, bool)


def lying(x: Floats, y: Floats) -> Floats:
    """Return the coordinates of cloth that lies flat, over places in the searched photo."""
    return np.stack([x / 24 + y / 200, y / 24 - x / 300], -1)


@pytest.fixture(scope="module")
def found() -> FoundCloth:
    kept = run(decompose(make_scene(motif(), basis=24.0 * np.eye(2)).photo)).found
    assert kept is not None
    return kept


def enlarged(found: FoundCloth, uv: Floats, cloth: Bools = EVERYWHERE, may_be: Bools | None = None) -> PixelModel:
    """Return coordinates (h, w, 2) on `cloth` (h, w) taken to a photo of `TIMES` the size."""
    valid = np.ones(LARGE_X.shape, bool) if may_be is None else may_be
    begun = begin(found.cloth, found.fit, np.full((*valid.shape, 3), 0.5, np.float32), valid, is_told=True)
    laid = np.where(cloth, 1.0, np.nan).astype(np.float32)
    layers = {"uv": uv.astype(np.float32) * laid[..., None], "shading": 0.8 * laid}
    return enlarge(replace(begun, **layers, outline=cloth, followed=cloth))  # type: ignore[arg-type]


def off_px(uv: Floats | Singles, expected: Floats) -> Floats:
    """Return how far (H, W) coordinates are off, in pixels of the searched photo; 0 where there are none."""
    return np.asarray(24 * np.nan_to_num(np.linalg.norm(uv - expected, axis=-1)), np.float64)


def test_coordinates_are_linear_between_pixels_and_go_straight_on_at_the_border(found: FoundCloth) -> None:
    model = enlarged(found, lying(X, Y))
    assert model.scale == TIMES
    assert model.inside.all()
    assert off_px(model.uv, lying(LARGE_X, LARGE_Y)).max() < 0.7
    assert np.percentile(off_px(model.uv, lying(LARGE_X, LARGE_Y)), 98) < 1e-2
    np.testing.assert_allclose(model.shading, 0.8, atol=1e-5)
    assert model.texel.shape == tuple(TIMES * samples for samples in found.cloth.texel_samples)


def test_cloth_that_jumps_is_on_one_side_or_the_other(found: FoundCloth) -> None:
    jump = np.array([3.0, 0.0])
    model = enlarged(found, lying(X, Y) + jump * (X > 95)[..., None])
    off = np.minimum(*(off_px(model.uv, lying(LARGE_X, LARGE_Y) + shift * jump) for shift in (0, 1)))
    assert model.inside.all()
    assert off.max() < 1
    over = off_px(model.uv, lying(LARGE_X, LARGE_Y)) > 36
    assert over[LARGE_X > 97].all()
    assert not over[LARGE_X < 94].any()


def test_cloth_ends_where_it_did_and_in_a_region_where_that_does(found: FoundCloth) -> None:
    may_be = np.arange(LARGE_X.shape[1]) * np.ones((len(LARGE_X), 1)) >= 62
    cloth = (X > 20) & (X < 100)
    model = enlarged(found, lying(X, Y), cloth, may_be)
    assert model.inside[:, 62:299].all()
    assert not model.inside[:, :62].any()
    assert not model.inside[:, 301:].any()
    np.testing.assert_array_equal(model.inside, model.outline)


def test_a_photo_of_the_searched_size_stays_as_it_is(found: FoundCloth) -> None:
    begun = begin(found.cloth, found.fit, found.photo, EVERYWHERE, is_told=True)
    assert enlarge(begun) is begun


def test_a_slanting_jump_has_no_steps_of_pixels_that_were_searched(found: FoundCloth) -> None:
    jump = np.array([3.0, 0.0])
    model = enlarged(found, lying(X, Y) + jump * (X > 0.7 * Y + 40)[..., None])
    over = off_px(model.uv, lying(LARGE_X, LARGE_Y)) > 36
    # Where the cloth goes over is a row's first column; it should be as far from that of the row before everywhere.
    first = over[30:-30].argmax(1) / TIMES
    off = first - np.polynomial.Polynomial.fit(np.arange(len(first)), first, 1)(np.arange(len(first)))
    assert np.abs(off).max() < 0.55


@pytest.mark.parametrize("rows", [0, 1])
def test_cloth_of_a_row_or_of_nothing_has_light(found: FoundCloth, rows: int) -> None:
    cloth = np.isin(Y, np.arange(80, 80 + rows))
    begun = begin(found.cloth, found.fit, found.photo, EVERYWHERE, is_told=True)
    shading = np.where(cloth, 0.8, np.nan).astype(np.float32)
    uv = np.where(cloth[..., None], lying(X, Y), np.nan).astype(np.float32)
    light = light_folds(draw_model(replace(begun, uv=uv, shading=shading, outline=cloth))).light
    np.testing.assert_array_equal(np.isfinite(light[..., 0]), cloth)
