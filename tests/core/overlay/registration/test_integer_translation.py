"""Separate pieces of cloth share one count of texels."""

import numpy as np
import pytest

from core.arrays import Bools
from core.overlay.mesh import ClothMesh
from core.overlay.registration.integer_translation import GAP, in_phase, quads
from core.overlay.registration.registration import ClothState

MESH = ClothMesh((160, 400), 8)
STEP_PX = 20.0


def piece(columns: slice, offset: tuple[float, float]) -> ClothState:
    """Return cloth of steps of `STEP_PX` under some columns of cells, its coordinates moved by `offset`."""
    cells: Bools = np.zeros(MESH.cells, bool)
    cells[2:-2, columns] = True
    uv = MESH.positions() / STEP_PX + np.array(offset)
    return ClothState(uv, np.ones(MESH.nodes), cells)


def test_a_piece_far_from_another_counts_on_from_it() -> None:
    first, second = in_phase(MESH, (piece(slice(0, 15), (0.0, 0.0)), piece(slice(35, 50), (70.3, -41.2))), STEP_PX)
    assert np.allclose(first.uv, MESH.positions() / STEP_PX)
    # What is left is less than a texel: only whole ones are moved.
    assert np.abs(second.uv - first.uv).max() < 0.5 + 1e-9


@pytest.mark.parametrize("offset", [(0.0, 0.0), (3.2, -0.4), (-50.0, 8.0)])
def test_pieces_side_by_side_keep_apart_but_no_more_than_they_must(offset: tuple[float, float]) -> None:
    pieces = in_phase(MESH, (piece(slice(0, 24), (0.0, 0.0)), piece(slice(25, 50), offset)), STEP_PX)
    apart = np.abs(quads(MESH, pieces[0])[:, None] - quads(MESH, pieces[1])).max(-1)
    assert apart.min() > GAP
    assert np.abs(pieces[1].uv - pieces[0].uv).max() <= GAP + 2


def test_a_piece_keeps_its_place_within_a_texel() -> None:
    before = piece(slice(25, 50), (3.25, -0.4))
    after = in_phase(MESH, (piece(slice(0, 24), (0.0, 0.0)), before), STEP_PX)[1]
    step = after.uv - before.uv
    assert np.allclose(step, np.rint(step[0, 0]), atol=1e-9)
