"""Registration on a coarser mesh: what it changes is carried to the finer one, and lies on the photo there."""

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import flat_canvas
from core.overlay.mesh import ClothMesh
from core.overlay.registration.cloth import FittedCloth, make_cloth
from core.overlay.registration.coarse_mesh import at_finer_nodes, coarsen, correct
from core.overlay.registration.fitting import register_under
from core.overlay.registration.registration import ClothState
from core.overlay.tolerances import SMOOTH_PX
from tests.core.overlay.overlay_scenes import Scene, make_scene, motif

SIZE, BASIS = (236, 282), np.array([[116.0, 6.0], [-5.0, 122.0]])
RNG = np.random.default_rng(0)


@pytest.mark.parametrize("cells", [(6, 8), (5, 7)])
def test_a_mesh_moves_as_its_coarser_one_does(cells: tuple[int, int]) -> None:
    mesh = ClothMesh((6 * cells[0], 6 * cells[1]), 6)
    places = mesh.positions()
    state = ClothState(places / 50 + RNG.normal(0, 0.01, places.shape), np.ones(mesh.nodes), RNG.random(cells) < 0.6)
    before = coarsen(mesh, state)
    used = mesh.nodes_of(state.cells)
    assert np.allclose(before.uv[: cells[0] // 2 + 1, : cells[1] // 2 + 1][1, 1], state.uv[2, 2])
    row, column = np.indices(before.rho.shape)
    change = np.stack([0.1 + 0.02 * row - 0.03 * column, 0.05 * row], -1)
    after = ClothState(before.uv + change, before.rho + 0.01 * column, before.cells)
    moved = correct(state, before, after)
    row, column = np.indices(mesh.nodes) / 2
    wanted = np.stack([0.1 + 0.02 * row - 0.03 * column, 0.05 * row], -1)
    assert np.allclose((moved.uv - state.uv)[used], wanted[used])
    assert np.allclose((moved.rho - 1)[used], 0.01 * column[used])
    assert np.array_equal(moved.cells, state.cells)


def make_start() -> tuple[Scene, FittedCloth, ClothState]:
    """Return a scene, its cloth, and where that lies if it is flat."""
    scene = make_scene(motif(), size=SIZE, basis=BASIS, bend=6.0)
    frames = PatchFrames(np.array([[140.0, 118.0]]), BASIS[None] / 5, np.ones(1))
    canvas = flat_canvas(scene.photo, np.ones(SIZE, np.bool_))
    cloth = make_cloth(scene.photo, canvas, Lattice(np.zeros((1, 2), np.int64), frames), 5 * np.eye(2))
    uv = cloth.mesh.positions() @ np.linalg.inv(BASIS).T
    return scene, cloth, ClothState(uv, np.ones(cloth.mesh.nodes), np.ones(cloth.mesh.cells, np.bool_))


def test_a_wide_blur_is_registered_on_the_coarser_mesh_and_lies_on_the_photo() -> None:
    scene, cloth, start = make_start()

    def off(piece: ClothState) -> float:
        away = (cloth.mesh.to_pixels(piece.uv, piece.cells) - scene.uv) @ BASIS.T
        return float(np.median(np.linalg.norm(away, axis=-1)))

    texel, (piece,) = register_under(cloth, motif(), (start,), 3, 8.0)
    assert texel.shape == cloth.coarser.texel_samples != cloth.texel_samples
    assert off(piece) < off(start) / 3
    texel, _ = register_under(cloth, motif(), (start,), 3, 1.0)
    assert texel.shape == cloth.texel_samples


def test_under_a_blur_stiff_cloth_bends_within_longer_lengths_and_is_as_smooth_as_any_without_one() -> None:
    _, cloth, start = make_start()
    bending = cloth.mesh.bending(np.ones(cloth.mesh.nodes, np.bool_))

    def bends(blur_px: float, *, is_stiff: bool) -> float:
        _, (piece,) = register_under(cloth, motif(), (start,), 3, blur_px, is_stiff=is_stiff)
        return float(np.square(bending @ piece.uv.reshape(-1, 2)).sum())

    assert bends(4.0, is_stiff=True) < bends(4.0, is_stiff=False) / 2
    assert bends(SMOOTH_PX, is_stiff=True) == bends(SMOOTH_PX, is_stiff=False)


@pytest.mark.parametrize("nodes", [(9, 12), (8, 13)])
def test_what_is_smooth_is_told_between_the_nodes_of_a_coarser_mesh(nodes: tuple[int, int]) -> None:
    fine, coarse = (ClothMesh((4 * nodes[0] - 4, 4 * nodes[1] - 4), cell).positions() for cell in (4, 8))

    def bent(places: Floats) -> Floats:
        x, y = np.moveaxis(places, -1, 0)
        return np.stack([x / 30 + 0.002 * x * y, np.sin(y / 20) + x / 40], -1)

    found = at_finer_nodes(bent(coarse), nodes)
    inner = slice(2, -2), slice(2, -2)
    np.testing.assert_allclose(found[inner], bent(fine)[inner], atol=2e-3)
    np.testing.assert_array_equal(found[::2, ::2], bent(coarse)[: -(-nodes[0] // 2), : -(-nodes[1] // 2)])
