"""Patches are compared as products of matrices say what comparing them one by one does."""

import numpy as np
import pytest

from core.arrays import Floats, Singles
from core.overlay.detection.alignment import FlatPicture, PatchFrames, align, make_template, raster, search
from core.overlay.detection.normalised_correlation import Forms, Windows, root

RNG = np.random.default_rng(3)
SIDE, CHANNELS, COUNT = 8, 3, 5


def without_means(values: Floats, weights: Floats) -> Floats:
    """Return values (N, C) less their mean under weights (N,), of norm one."""
    centred = (values - (weights[:, None] * values).sum(0) / weights.sum()) * weights[:, None]
    return np.asarray(centred / np.linalg.norm(centred))


def forms(count: int) -> Singles:
    values = RNG.normal(size=(count, SIDE**2, CHANNELS))
    values -= values.mean(1, keepdims=True)
    values[0] /= np.linalg.norm(values[0])
    return values.astype(np.float32)


@pytest.mark.parametrize("cut", [False, True])
def test_forms_of_patches_are_those_of_each_less_its_mean_over_its_norm(cut: bool) -> None:
    given = forms(4)
    patches = RNG.normal(2.0, 0.3, (COUNT, SIDE**2, CHANNELS)).astype(np.float32)
    weights = np.ones((COUNT, SIDE**2), np.float32)
    if cut:
        weights[1, : SIDE**2 // 3] = weights[2, ::7] = 0
        weights[3, : 2 * SIDE**2 // 3] = 0
    scores, differences = Forms(given).compared(patches, weights if cut else None)
    for row, (patch, weight) in enumerate(zip(patches.astype(float), weights.astype(float), strict=True)):
        mine, theirs = without_means(patch, weight), without_means(given[0].astype(float), weight)
        assert scores[row] == pytest.approx(-1 if cut and row == 3 else (mine * theirs).sum(), abs=1e-4)
        expected = ((mine - theirs) * given[1:]).sum((1, 2))
        assert differences[row] == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("cut", [False, True])
def test_windows_compare_the_template_at_each_place_of_the_wider_raster(cut: bool) -> None:
    shifts = 2
    template = forms(1)[0].reshape(SIDE, SIDE, CHANNELS)
    windows = Windows(template, shifts)
    patches = RNG.normal(2.0, 0.3, (COUNT, windows.side, windows.side, CHANNELS)).astype(np.float32)
    weights = np.ones(patches.shape[:3], np.float32)
    if cut:
        weights[1, : SIDE // 2] = weights[2, :, -2:] = 0
        weights[3, :, : SIDE + 2] = 0
    flat = patches.reshape(COUNT, -1, CHANNELS)
    found = windows.scores(flat, weights.reshape(COUNT, -1) if cut else None)
    for row in range(COUNT):
        for place, (top, left) in enumerate((i, j) for i in range(2 * shifts + 1) for j in range(2 * shifts + 1)):
            box = row, slice(top, top + SIDE), slice(left, left + SIDE)
            weight = weights[box].astype(float).ravel()
            mine, theirs = (
                (
                    without_means(values.reshape(-1, CHANNELS).astype(float), weight)
                    for values in (patches[box], template)
                )
                if weight.any()
                else (np.zeros(1), np.zeros(1))
            )
            known = weight.mean() > 0.5
            assert found[row, place] == pytest.approx((mine * theirs).sum() if known else -1, abs=1e-4)


def test_an_even_patch_is_like_nothing() -> None:
    even = np.full((1, SIDE**2, CHANNELS), 0.7, np.float32)
    assert abs(Forms(forms(1)).compared(even, None)[0][0]) < 0.05


def test_a_frame_is_found_beside_where_it_is_expected_and_half_outside_the_region() -> None:
    y, x = np.mgrid[:120, :140].astype(np.float32)
    picture = np.stack([np.sin(x / 6 + np.cos(y / 9)), np.cos(y / 5), np.sin((x + y) / 7)], -1) + 2
    basis = np.array([[20.0, 3.0], [-2.0, 18.0]])
    at = raster(0.75, 20) @ basis.T + (60, 55)
    values = np.stack([np.sin(at[:, 0] / 6 + np.cos(at[:, 1] / 9)), np.cos(at[:, 1] / 5), np.sin(at.sum(1) / 7)], -1)
    template = make_template(values.reshape(20, 20, 3).astype(np.float32), 0.75)
    valid = np.ones((120, 140, 1), np.float32)
    beside = PatchFrames(np.array([[60.0, 55.0]]) + basis @ (0.2, -0.15), basis[None], np.ones(1))
    for cut in (False, True):
        valid[:, : 55 * cut] = 0
        canvas = FlatPicture(picture * valid, valid)
        near = search(canvas, template, beside)
        assert np.abs(np.linalg.solve(basis, near.points[0] - (60, 55))).max() < 0.06
        found = align(canvas, template, near)
        assert np.abs(found.points[0] - (60, 55)).max() < (0.5 if cut else 0.05)
        assert found.scores[0] > 0.99


def test_norm_of_what_is_hardly_known_is_a_number() -> None:
    rounded = np.array([[-1e-4], [0.0], [1.0]], np.float32)
    assert root(rounded, rounded)[:, 0] == pytest.approx([1e-6, 1e-6, 1.0])
