"""The energies that unfolding minimises: their slopes, their curvatures and the systems these make up."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from core.grid import Grid
from core.mapping.assembly import Assembly, packed, triangle
from core.mapping.distortion import Barrier, Corners, Hinge, Penalty
from core.mapping.folds import corner_areas, folded_quads
from core.mapping.frames import Complexes, as_complex
from core.mapping.release import Leash

GRID = Grid(240, 180, cell_px=3)


def test_unknowns_are_solved_for_alike_whatever_their_weight() -> None:
    assembly = Assembly(3, [np.arange(3)[:, None]])
    weights = np.array([1e12, 1.0, 0.0])
    entries = assembly.entries([weights[:, None]])
    np.testing.assert_allclose(assembly.solve(entries, weights), [1, 1, 0], rtol=1e-6)


def test_elements_that_meet_an_unknown_twice_add_up_to_the_whole_system() -> None:
    chance = np.random.default_rng(0)
    dofs = np.array([[0, 1, 0, 2], [2, 3, 1, 2], [4, 4, 0, 5]])
    halves = chance.random((3, 4, 4))
    elements = halves @ halves.transpose(0, 2, 1) + np.eye(4)
    whole = np.zeros((6, 6))
    for of, element in zip(dofs, elements, strict=True):
        np.add.at(whole, np.ix_(of, of), element)
    b = chance.random(5)
    assembly = Assembly(5, [dofs])
    np.testing.assert_allclose(
        assembly.solve(assembly.entries([packed(elements)]), b), np.linalg.solve(whole[:5, :5], b)
    )


def test_slopes_of_the_outline_s_energy_are_those_of_the_energy() -> None:
    z = as_complex(GRID.nodes).ravel() + np.random.default_rng(0).normal(0, 1, (GRID.size, 2)) @ [1, 1j]
    every = np.ones(GRID.size, bool)
    leash = Leash(GRID, every, every, as_complex(GRID.nodes), 9.0)
    leash.tie(GRID.outline.ravel() & (np.arange(GRID.size) < 20), 3.0)
    gradient, _ = leash.model(z)
    total = np.zeros((GRID.size, 2))
    np.add.at(total, leash.edges, gradient.reshape(-1, 2, 2))
    for node in (0, 5, GRID.columns - 1):
        for axis in (0, 1):
            move = np.zeros(GRID.size, np.complex128)
            move[node] = 1e-5 * (1, 1j)[axis]
            slope = (leash.energy(z + move) - leash.energy(z - move)) / 2e-5
            assert np.isclose(slope, total[node, axis], rtol=1e-5, atol=1e-6)


def squares(seed: int, wobble: float) -> Complexes:
    noise = np.random.default_rng(seed).normal(0, wobble, (12, 4, 2)).view(np.complex128)[..., 0]
    return np.asarray((np.array([0, 1, 1 + 1j, 1j]) + noise).T)


@settings(max_examples=20)
@given(st.integers(0, 10_000), st.sampled_from([Hinge(0.3), Barrier(0.2), Barrier(1.0)]))
def test_slopes_are_those_of_the_energy_and_curvature_is_never_negative(seed: int, penalty: Penalty) -> None:
    corners, z = Corners.of(squares(seed, 0.05)), squares(seed + 1, 0.4)
    gradient, curvature = penalty.model(corners, z)
    row, column = triangle(8)
    whole = np.zeros((12, 8, 8))
    whole[:, row, column] = whole[:, column, row] = curvature
    assert np.linalg.eigvalsh(whole).min() > -1e-7 * np.abs(whole).max()
    step = 1e-6
    for i in range(8):
        move = np.zeros((4, 12), np.complex128)
        move[i // 2] = step * (1j if i % 2 else 1)
        slope = (penalty.energy(corners, z + move) - penalty.energy(corners, z - move)) / (2 * step)
        assert np.allclose(slope, gradient[:, i], rtol=1e-4, atol=1e-4 * np.abs(gradient).max())


def test_a_quad_is_folded_when_one_corner_is() -> None:
    z = as_complex(Grid(3, 3, cell_px=1).nodes).copy()
    assert not folded_quads(z).any()
    assert np.allclose(corner_areas(z), 1)
    z[1, 1] += 1.2 + 1.2j
    assert folded_quads(z).sum() == 3
