"""The factor that is renewed in parts: against a dense solve, and against itself built at once."""

import numpy as np
import pytest
from scipy import sparse

from core.arrays import Bools, Floats, SingularSystemError
from core.linalg import dissection, fronts, multifrontal
from core.linalg.dissection import dissect
from core.linalg.laplacian import edge_weights, find_stored, node_values, pattern
from core.linalg.multifrontal import GridFactor

SHAPES = [(3, 3), (3, 40), (9, 9), (25, 31), (70, 41)]


def system(shape: tuple[int, int], seed: int) -> tuple[Floats, Bools]:
    """Return the values of a five-point system with random weights and holes, and which nodes are free."""
    chance = np.random.default_rng(seed)
    free = np.zeros(shape, bool)
    free[1:-1, 1:-1] = chance.random((shape[0] - 2, shape[1] - 2)) < 0.9
    weights = chance.choice([1.0, 100.0], (shape[0] - 1, shape[1] - 1))
    return node_values(edge_weights(weights), free), free


def matrix_of(values: Floats) -> sparse.csc_array:
    shape = values.shape[:2]
    lower = pattern((shape[0], shape[1]))
    lower.data = values[find_stored(shape)]
    return sparse.csc_array(lower + sparse.tril(lower, -1).T)


def load(free: Bools, seed: int) -> Floats:
    return np.asarray(np.random.default_rng(seed).random((free.size, 2)) * free.reshape(-1, 1))


def with_a_hole(values: Floats, free: Bools, row: int, column: int) -> tuple[Floats, Bools]:
    """Return the system with the nodes around one place held."""
    less = free.copy()
    less[row - 2 : row + 3, column - 2 : column + 3] = False
    changed = values.copy()
    changed[~less] = [1, 0, 0]
    changed[:, :-1, 1] *= less[:, 1:]
    changed[:-1, :, 2] *= less[1:]
    return changed, less


@pytest.mark.parametrize("shape", SHAPES)
def test_solves_the_system(shape: tuple[int, int]) -> None:
    values, free = system(shape, 1)
    b = load(free, 2)
    x = GridFactor(shape).factorise(values).solve(b)
    assert np.abs(matrix_of(values) @ x - b).max() < 1e-11


@pytest.mark.parametrize("shape", SHAPES)
def test_the_halves_make_a_solve_and_its_form(shape: tuple[int, int]) -> None:
    values, free = system(shape, 3)
    a, b = load(free, 4), load(free, 5)
    factor = GridFactor(shape).factorise(values)
    assert np.allclose(factor.forward(a).T @ factor.forward(b), a.T @ factor.solve(b))


@pytest.mark.parametrize("shape", [(3, 3), (1, 40), (7, 7), (8, 14), (68, 39), (124, 188)])
def test_every_node_is_eliminated_once_and_boxes_come_in_few_layouts(shape: tuple[int, int]) -> None:
    seen = np.zeros((2 * shape[0] + 16, 2 * shape[1] + 16), int)
    groups = dissect(shape)
    for group in groups:
        for row, column in group.corners:
            for i, j in group.pivots():
                seen[row + i, column + j] += 1
    assert (seen[: shape[0], : shape[1]] == 1).all()
    assert seen.max() == 1
    assert seen.sum() < 1.4 * shape[0] * shape[1]
    assert sum(group.tiles < 1 for group in groups) <= 4


@pytest.mark.parametrize("leaves", [1, 2, 4, 8])
def test_changes_in_a_few_places_leave_the_factor_that_all_at_once_gives(
    leaves: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dissection, "_LEAVES", leaves)
    shape = SHAPES[-1]
    values, free = system(shape, 6)
    factor = GridFactor(shape).factorise(values)
    factor.forward_again(load(free, 7), np.arange(factor.size))
    for step, place in enumerate([(20, 20), (21, 22), (3, 37), (66, 3)]):
        values, free = with_a_hole(values, free, *place)
        b = load(free, 7 + step // 2)
        factor.factorise(values)
        afresh = GridFactor(shape).factorise(values)
        assert np.array_equal(factor.forward_again(b, np.arange(factor.size)), afresh.forward(b).whole)
        assert np.array_equal(factor.solve(b), afresh.solve(b))


def test_a_change_renews_a_small_share_of_the_boxes() -> None:
    shape = SHAPES[-1]
    values, free = system(shape, 8)
    factor = GridFactor(shape).factorise(values)
    factor.forward_again(load(free, 9), np.arange(factor.size))
    factor.factorise(with_a_hole(values, free, 20, 20)[0])
    assert 0 < factor._renewed.sum() < 0.4 * len(factor._renewed)


def test_columns_that_live_on_a_few_nodes_are_eliminated_there() -> None:
    shape = SHAPES[-1]
    values, free = system(shape, 10)
    factor = GridFactor(shape).factorise(values)
    b = load(free, 11)
    nodes = np.flatnonzero(free)[[5, 6, 400, 1700]]
    few = np.zeros(b.shape)
    few[nodes] = b[nodes]
    assert np.array_equal(factor.forward(few, nodes).whole, factor.forward(few).whole)
    assert len(factor.forward(few, nodes).rows) < 0.4 * factor.size
    assert factor.forward(few[:, :0], nodes).whole.shape == (factor.forward(few).size, 0)


def test_one_load_after_another_at_other_nodes_is_eliminated_as_it_is_by_itself() -> None:
    shape = SHAPES[-1]
    values, free = system(shape, 16)
    factor = GridFactor(shape).factorise(values)
    live = np.flatnonzero(free)
    for seed, nodes in enumerate((live[5:90], live[5:90], live[1700:1702], live[60:200])):
        b = load(free, 17 + seed)[nodes]
        alone = np.zeros((factor.size, 2))
        alone[nodes] = b
        assert np.array_equal(factor.forward_again(b, nodes), factor.forward(alone, nodes).whole)


def test_what_has_no_unique_solution_is_refused_and_can_be_mended() -> None:
    shape = SHAPES[2]
    values, free = system(shape, 12)
    broken = values.copy()
    broken[4, 4, 0] = 0
    factor = GridFactor(shape).factorise(values)
    with pytest.raises(SingularSystemError):
        factor.factorise(broken)
    b = load(free, 13)
    assert np.array_equal(factor.factorise(values).solve(b), GridFactor(shape).factorise(values).solve(b))


def test_large_grids_keep_less_and_have_the_same_factor(monkeypatch: pytest.MonkeyPatch) -> None:
    shape = (230, 170)
    values, free = system(shape, 14)
    all_kept = GridFactor(shape).factorise(values)
    monkeypatch.setattr(multifrontal, "_ALL_KEPT_AT_MOST", 100)
    monkeypatch.setattr(multifrontal, "_LEAST_KEPT", 6)
    monkeypatch.setattr(multifrontal, "_BOXES_AT_ONCE", 90)
    factor = GridFactor(shape).factorise(values)
    assert _kept_bytes(factor) < 0.6 * _kept_bytes(all_kept)
    for step, place in enumerate([(20, 20), (120, 90), (121, 91), (226, 3)]):
        b = load(free, 15 + step)
        assert np.array_equal(factor.solve(b), all_kept.solve(b))
        assert np.array_equal(
            factor.forward_again(b, np.arange(factor.size)), all_kept.forward_again(b, np.arange(factor.size))
        )
        values, free = with_a_hole(values, free, *place)
        factor.factorise(values)
        all_kept.factorise(values)
        assert 0 < factor._renewed.sum() < 0.5 * len(factor._renewed)


def _kept_bytes(factor: GridFactor) -> int:
    return sum(group._S.nbytes for group in factor._fronts)


@pytest.mark.parametrize("size", [5, 150, 151, 640])
def test_a_long_front_is_solved_block_by_block(size: int) -> None:
    A = np.random.default_rng(size).normal(size=(2, size, size))
    A = A @ A.transpose(0, 2, 1) + size * np.eye(size)
    b = np.random.default_rng(1).normal(size=(2, size, 3))
    factor = fronts._factorise(A)
    assert np.allclose(A @ fronts.solve_upper(factor, fronts.solve_lower(factor, b)), b, atol=1e-9)
    assert np.allclose(np.linalg.cholesky(A) @ fronts.solve_lower(factor, b), b, atol=1e-9)
    assert np.array_equal(factor, np.tril(factor))


def test_a_long_front_that_is_not_definite_is_refused() -> None:
    with pytest.raises(np.linalg.LinAlgError):
        fronts._factorise(-np.eye(400)[None])
