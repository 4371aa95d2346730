"""Cloth that is carried on and registered."""

import numpy as np

from core.arrays import Floats
from core.overlay.registration.cloth import estimate, measure
from core.overlay.registration.constrained_registration import settle
from core.overlay.registration.registration import ClothState
from tests.core.overlay.pixels.test_filling import SCENE, SIZE, straight

CELLS, WANTED = 8, 12
"""Columns of cells that are followed, and columns up to which cloth is wanted beyond."""
ALL = (slice(0, SIZE[0]), slice(0, SIZE[1]))


def carried_beside(photo: Floats, wanted_px: int, off_px: float) -> tuple[ClothState, ClothState, Floats]:
    """Return a piece carried on that far beside the photo, settled, and how far (H, W) it then is, pixels."""
    cloth, whole = straight(photo, np.ones(SIZE, bool))
    cells = np.zeros(cloth.mesh.cells, bool)
    cells[:, :CELLS] = True
    found = measure(
        cloth, estimate(cloth, (ClothState(whole.uv, whole.rho, cells),)), (ClothState(whole.uv, whole.rho, cells),)
    )
    uv = np.where(
        cloth.mesh.nodes_of(cells)[..., None], whole.uv, whole.uv + off_px / np.linalg.norm(SCENE.basis[:, 0])
    )
    piece = ClothState(uv, whole.rho, cells)
    covered = cloth.mesh.pixels_of(cells)
    wanted = ~covered & (np.indices(SIZE)[1] < wanted_px)
    moved = settle(cloth, found, piece, wanted, covered)
    away = cloth.mesh.smooth_to_pixels(moved.uv - whole.uv, ALL) @ SCENE.basis.T
    return piece, moved, np.where(wanted, np.linalg.norm(away, axis=-1), 0.0)


def end_px() -> int:
    cloth, _ = straight(SCENE.photo, np.ones(SIZE, bool))
    return WANTED * cloth.mesh.cell


def test_cloth_that_is_carried_on_beside_the_photo_comes_to_lie_on_it() -> None:
    piece, moved, away = carried_beside(SCENE.photo, end_px(), 2.0)
    assert away[away > 0].mean() < 0.3
    assert np.array_equal(moved.cells, piece.cells)
    assert np.array_equal(moved.uv[:, : CELLS + 1], piece.uv[:, : CELLS + 1])


def test_what_is_not_wanted_does_not_pull() -> None:
    # The last cells are mostly of something else.
    end = end_px() - 4
    photo = SCENE.photo.copy()
    photo[:, end:] = np.roll(photo, 3, 0)[:, end:]
    _, _, away = carried_beside(photo, end, 0.0)
    assert away[:, end - 2 : end].mean() < 0.3


def test_nothing_wanted_leaves_the_piece() -> None:
    piece, moved, _ = carried_beside(SCENE.photo, 0, 2.0)
    assert moved is piece
