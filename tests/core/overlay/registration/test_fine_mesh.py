"""Registration on cells that are small beside folds, as smooth as on larger ones."""

import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import flat_canvas
from core.overlay.mesh import ClothMesh
from core.overlay.registration.cloth import Fit, FittedCloth, make_cloth, measure
from core.overlay.registration.fine_mesh import SIDES_PX, register_finely, resample
from core.overlay.registration.registration import ClothState
from core.overlay.texel import Texel
from tests.core.overlay.overlay_scenes import motif

SIZE, BASIS = (150, 186), np.array([[48.0, 3.0], [-2.0, 46.0]])
FOLD_PX = 60.0
"""From one fold to the next."""


def folded(amplitude_px: float) -> Floats:
    """Return coordinates (H, W, 2) of cloth in folds that move it to both sides by so much."""
    y, x = np.indices(SIZE).astype(float)
    return np.stack([x + amplitude_px * np.sin(2 * np.pi * x / FOLD_PX), y], -1) @ np.linalg.inv(BASIS).T


def start_on(photo: Floats) -> tuple[FittedCloth, Fit]:
    """Return a cloth that lies flat, in all cells but those at the photo's rim."""
    frames = PatchFrames(np.array([[90.0, 70.0]]), BASIS[None], np.ones(1))
    lattice = Lattice(np.zeros((1, 2), np.int64), frames)
    cloth = make_cloth(photo, flat_canvas(photo, np.ones(SIZE, np.bool_)), lattice, np.eye(2))
    cells: Bools = np.pad(np.ones(np.subtract(cloth.mesh.cells, 2), np.bool_), 1)
    uv = cloth.mesh.positions() @ np.linalg.inv(BASIS).T
    piece = ClothState(uv, np.ones(cloth.mesh.nodes), cells)
    return cloth, measure(cloth, motif(), (piece,))


def off_px(cloth: FittedCloth, piece: ClothState, uv: Floats) -> Floats:
    """Return how far (n,) a piece's pixels lie from where they are, pixels."""
    away = (cloth.mesh.smooth_to_pixels(piece.values, (slice(0, SIZE[0]), slice(0, SIZE[1])))[..., :2] - uv) @ BASIS.T
    return np.asarray(np.linalg.norm(away, axis=-1)[cloth.mesh.pixels_of(piece.cells)], np.float64)


def test_folds_are_followed_on_the_finer_mesh() -> None:
    uv = folded(1.5)
    cloth, flat = start_on(motif()(uv))
    fine, finer = register_finely(cloth, flat)
    before, after = off_px(cloth, flat.pieces[0], uv), off_px(fine, finer.pieces[0], uv)
    assert fine.mesh.cell == SIDES_PX[1] < cloth.mesh.cell / 2
    assert after.mean() < 0.6 * before.mean()


def test_where_the_photo_says_no_more_finer_cells_say_no_more() -> None:
    # Motifs on plain ground, which has noise: it is nothing to follow.
    uv = folded(0.0)
    t = (np.arange(48) + 0.5) / 48
    u, v = np.meshgrid(t, t)
    dots = Texel(np.where((np.hypot(u - 0.5, v - 0.5) < 0.16)[..., None], [0.1, 0.2, 0.5], [0.8, 0.8, 0.7]))
    photo = np.clip(dots(uv) + np.random.default_rng(0).normal(0, 0.03, (*SIZE, 3)), 0, 1)
    cloth, flat = start_on(photo)
    fine, finer = register_finely(cloth, measure(cloth, dots, flat.pieces))
    assert off_px(fine, finer.pieces[0], uv).mean() < 0.1


@pytest.mark.parametrize("cell", [3, 5])
def test_cloth_lies_on_a_finer_mesh_as_before(cell: int) -> None:
    mesh, finer = ClothMesh(SIZE, 12), ClothMesh(SIZE, cell)
    x, y = np.moveaxis(mesh.positions(), -1, 0)
    cells: Bools = np.random.default_rng(1).random(mesh.cells) < 0.6
    uv = np.stack([x / 40 + 0.1 * np.sin(y / 30), y / 50 + 0.0005 * x * y], -1)
    used = mesh.nodes_of(cells)
    # What is beyond the cells in use counts for nothing.
    state = ClothState(np.where(used[..., None], uv, 99.0), np.where(used, 0.5 + x / 300, 99.0), cells)
    same = resample(mesh, state, finer)
    inner = finer.pixels_of(same.cells) & mesh.pixels_of(cells)
    everywhere = slice(0, SIZE[0]), slice(0, SIZE[1])
    found = finer.smooth_to_pixels(same.values, everywhere)[inner]
    wanted = mesh.smooth_to_pixels(np.concatenate([uv, (0.5 + x / 300)[..., None]], -1), everywhere)[inner]
    np.testing.assert_allclose(found, wanted, atol=5e-3)
    assert inner.sum() > 0.85 * mesh.pixels_of(cells).sum()


def test_cells_that_are_as_small_stay() -> None:
    cloth, flat = start_on(motif()(folded(0.0)))
    fine, finer = register_finely(cloth, flat)
    assert register_finely(fine, finer) == (fine, finer)
