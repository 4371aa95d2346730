"""Whole texels by which cloth is moved where it was followed one too many or too few."""

import numpy as np
import pytest

from core.arrays import Bools, Floats, Ints
from core.overlay.pixels.gaps.unwrapping import unwrap

STEP = 10.0
BASIS = np.diag([STEP, STEP])
Y, X = np.indices((140, 180)).astype(float)
UV = np.stack([X / STEP + 0.2 * np.sin(Y / 50), Y / STEP + 0.2 * np.sin(X / 60)], -1)
NOTHING = np.zeros(Y.shape, bool)


def freed(uv: Floats, sheet: Ints | None = None, torn: Bools = NOTHING) -> tuple[Floats, Bools]:
    return unwrap(uv, np.ones(Y.shape, np.int64) if sheet is None else sheet, torn, BASIS, STEP)


def off(uv: Floats, where: Bools) -> Floats:
    """Return by how many texels (n, 2) coordinates miss, but for whole texels that are the same everywhere."""
    missed = (uv - UV)[where]
    return np.asarray(missed - np.rint(np.median(missed, axis=0)), np.float64)


def test_cloth_that_is_followed_well_stays() -> None:
    for uv in (UV, UV * [1.0, 0.8] + 0.3 * UV[..., ::-1], UV + 0.1 * np.random.default_rng(0).random(UV.shape)):
        moved, sure = freed(uv)
        assert np.ptp(moved, axis=(0, 1)).max() == 0
        assert sure.all()


@pytest.mark.parametrize("joined", [True, False])
def test_a_row_too_many_on_one_side_of_a_seam_is_taken_back_there(joined: bool) -> None:
    """Left of the seam the cloth is squeezed and stretched again, so that the part between is a row ahead."""
    squeezed = np.clip((Y - 40) / 8, 0, 1) - np.clip((Y - 90) / 8, 0, 1)
    seam = np.abs(X - 80) < 4
    uv = UV + np.where((X < 80)[..., None], squeezed[..., None] * [0.0, 1.0], 0.0)
    moved, sure = freed(uv, np.where(seam, 0, np.where(joined | (X < 80), 1, 2)))
    assert (np.abs(off(uv, sure)[:, 1]) > 0.6).mean() > 0.1
    assert (np.abs(off(uv + moved, sure)[:, 1]) > 0.6).mean() < 0.01
    assert sure[~seam].mean() > 0.95


@pytest.mark.parametrize("hidden", [0.5, 1.5])
def test_a_fold_that_hides_no_whole_texels_is_left_alone(hidden: float) -> None:
    fold = np.abs(X - 90) < 3
    uv = UV + np.where((X > 90)[..., None], [hidden, 0.0], 0.0)
    moved, _ = freed(uv, np.where(fold, 0, np.where(X > 90, 2, 1)), fold)
    for side in (X < 85, X > 95):
        assert np.ptp(moved[side], axis=0).max() == 0


def test_separate_sheets_come_within_a_texel() -> None:
    fold = np.abs(X - 90) < 3
    uv = UV + np.where((X > 90)[..., None], [23.0, -18.0], 0.0)
    moved, sure = freed(uv, np.where(fold, 0, np.where(X > 90, 2, 1)), fold)
    assert np.abs(off(uv + moved, sure)).max() < 0.01


def test_slivers_beside_a_tear_are_not_sure() -> None:
    torn, sliver = np.abs(X - 88) < 2, (np.abs(X - 95.5) < 1) & (Y > 60)
    bare = torn | ((X > 88) & (Y > 60) & ~sliver)
    _, sure = freed(UV, np.where(bare, 0, 1), torn)
    assert not sure[sliver & (Y > 66)].any()
    assert sure[~bare & ~sliver].mean() > 0.98
    _, sure = freed(UV, np.where(bare, 0, 1))
    assert sure[sliver].all()


def test_nothing_sure_and_pictures_smaller_than_a_pair_are_no_error() -> None:
    moved, sure = freed(UV, np.zeros(Y.shape, np.int64))
    assert not moved.any()
    assert not sure.any()
    for h, w in ((3, 40), (40, 3), (3, 3), (15, 14)):
        moved, sure = unwrap(UV[:h, :w], np.ones((h, w), np.int64), NOTHING[:h, :w], BASIS, STEP)
        assert not moved.any()
        assert sure.all()
