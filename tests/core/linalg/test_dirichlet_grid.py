import numpy as np
import pytest

from core.arrays import Floats, Points
from core.linalg import dirichlet_grid
from core.linalg.dirichlet_grid import DirichletGrid, Responses

CELL = 1.1, 0.9


def matrix(rows: int, columns: int) -> Floats:
    """Return L of the inner nodes, dense."""
    down, across = (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1) for n in (rows - 2, columns - 2))
    return np.kron(down, np.eye(columns - 2)) / CELL[1] ** 2 + np.kron(np.eye(rows - 2), across) / CELL[0] ** 2


def reading(rows: int, columns: int, places: Points) -> Floats:
    """Return the bilinear weights of the inner nodes at `places`."""
    hats = [
        np.maximum(1 - np.abs(place[:, None] - np.arange(n)), 0)
        for place, n in zip(places.T, (columns, rows), strict=True)
    ]
    return np.asarray((hats[1][:, 1:-1, None] * hats[0][:, None, 1:-1]).reshape(len(places), -1))


@pytest.mark.parametrize("shape", [(12, 19), (23, 9), (3, 3)])
@pytest.mark.parametrize("shift", [0.0, 0.3])
@pytest.mark.parametrize("strips", ["one", "several"])
def test_responses_and_fields_are_those_of_the_matrix(
    shape: tuple[int, int], shift: float, strips: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if strips == "several":
        monkeypatch.setattr(dirichlet_grid, "_MOST_EXPONENT", 3.0)
    rows, columns = shape
    places = np.random.default_rng(3).uniform(0, [columns - 1, rows - 1], (25, 2))
    places[1], places[2], places[3] = places[0] + 1e-3, (1.0, 1.0), (columns - 1, rows - 1)
    grid, C = DirichletGrid(rows, columns, cell=CELL), reading(rows, columns, places)
    inverse = np.linalg.inv(matrix(rows, columns) + shift * np.eye((rows - 2) * (columns - 2)))
    np.testing.assert_allclose(Responses(grid, shift=shift).between(places), C @ inverse @ C.T, atol=1e-12)
    loads = np.random.default_rng(4).normal(size=(25, 2))
    field = grid.spread(grid.loads_at(places), loads.T, shift)
    np.testing.assert_allclose(field[:, 1:-1, 1:-1].reshape(2, -1).T, inverse @ C.T @ loads, atol=1e-12)
    load = np.pad((C.T @ loads).T.reshape(2, rows - 2, columns - 2), [(0, 0), (1, 1), (1, 1)])
    np.testing.assert_allclose(grid.solve(load, shift), field, atol=1e-12)


def test_exponents_of_a_large_grid_do_not_overflow() -> None:
    grid = DirichletGrid(901, 901)
    places = np.random.default_rng(5).uniform(0, 900, (40, 2))
    read = reading(901, 901, places).reshape(40, 899, 899)
    field = grid.spread(grid.loads_at(places), np.eye(40)[:1], 0.0)[0, 1:-1, 1:-1]
    np.testing.assert_allclose(Responses(grid).between(places)[0], (read * field).sum(axis=(1, 2)), atol=1e-12)
