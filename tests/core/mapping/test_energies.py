"""The energies that unfolding minimises: their slopes, their curvatures and the systems these make up."""

import numpy as np

from core.grid import Grid
from core.linalg.assembly import Assembly, pack
from core.mapping.folds import corner_areas, find_folded_quads
from core.mapping.jacobians import as_complex

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
    np.testing.assert_allclose(assembly.solve(assembly.entries([pack(elements)]), b), np.linalg.solve(whole[:5, :5], b))


def test_a_quad_is_folded_when_one_corner_is() -> None:
    z = as_complex(Grid(3, 3, cell_px=1).nodes).copy()
    assert not find_folded_quads(z).any()
    assert np.allclose(corner_areas(z), 1)
    z[1, 1] += 1.2 + 1.2j
    assert find_folded_quads(z).sum() == 3
