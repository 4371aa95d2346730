"""Which way up a piece of cloth lies."""

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.mesh import ClothMesh
from core.overlay.registration.orientation import symmetry, turned
from core.overlay.registration.registration import ClothState
from core.overlay.texel import Texel
from tests.core.overlay.overlay_scenes import marked_checks, motif

MESH = ClothMesh((60, 120), 6)
BASIS = np.array([[20.0, 2.0], [-1.0, 22.0]])
UV = (MESH.positions() @ np.linalg.inv(BASIS).T).reshape(*MESH.nodes, 2)
LEFT = np.arange(MESH.cells[1])[None] + np.zeros((MESH.cells[0], 1)) < 9


def piece(uv: Floats, *, left: bool) -> ClothState:
    return ClothState(uv, np.ones(MESH.nodes), LEFT if left else ~LEFT)


@pytest.mark.parametrize("turn", [[[-1, 0], [0, -1]], [[0, -1], [1, 0]], [[0, 1], [-1, 0]]])
def test_a_piece_of_checks_is_turned_to_lie_as_the_cloth_beside_it(turn: list[list[int]]) -> None:
    checks = marked_checks(mark=False)
    upside_down = piece(UV @ np.array(turn, float).T + [3.2, 0.7], left=False)
    found = turned(MESH, upside_down, (piece(UV, left=True),), checks, BASIS)
    slopes = [np.diff(found.uv, axis=axis).mean((0, 1)) / 6 for axis in (1, 0)]
    np.testing.assert_allclose(np.stack(slopes, -1), np.linalg.inv(BASIS), atol=1e-6)
    np.testing.assert_allclose(checks(found.uv), checks(upside_down.uv), atol=0.12)


def test_a_piece_that_lies_alike_and_a_pattern_that_shows_its_way_up_stay() -> None:
    upright = piece(UV + [0.3, 0.2], left=False)
    assert turned(MESH, upright, (piece(UV, left=True),), marked_checks(mark=False), BASIS) is upright
    upside_down = piece(-UV, left=False)
    assert turned(MESH, upside_down, (piece(UV, left=True),), motif(), BASIS) is upside_down


def test_of_two_pieces_the_nearer_one_tells() -> None:
    checks, far = marked_checks(mark=False), np.zeros(MESH.cells, bool)
    far[:, :7] = True
    others = ClothState(UV, np.ones(MESH.nodes), far), ClothState(-UV, np.ones(MESH.nodes), LEFT & ~far)
    found = turned(MESH, piece(-UV, left=False), others, checks, BASIS)
    np.testing.assert_array_equal(found.uv, -UV)


def test_a_turned_texel_is_found_again_with_its_shift() -> None:
    texel, turn = motif(64), np.array([[-1.0, 0.0], [0.0, -1.0]])
    both = Texel((texel.pixels + np.roll(texel.pixels[::-1, ::-1], (5, -9), (0, 1))) / 2)
    alike, shift = symmetry(both, turn)
    assert alike > 0.99
    at = np.random.default_rng(0).random((20, 20, 2))
    np.testing.assert_allclose(both(at @ turn.T + shift), both(at), atol=0.03)
    assert symmetry(texel, turn)[0] < 0.9
