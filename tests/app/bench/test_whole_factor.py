"""What the bench compares with solves the same system."""

import numpy as np
import pytest

from app.bench.whole_factor import WholeFactor
from core.linalg.laplacian import edge_weights, node_values
from core.linalg.multifrontal import GridFactor


@pytest.mark.parametrize("shape", [(20, 30), (150, 130), (700, 9)])
def test_it_solves_as_the_factor_in_parts_does(shape: tuple[int, int]) -> None:
    chance = np.random.default_rng(14)
    free = np.zeros(shape, bool)
    free[1:-1, 1:-1] = chance.random((shape[0] - 2, shape[1] - 2)) < 0.9
    values = node_values(edge_weights(chance.choice([1.0, 100.0], (shape[0] - 1, shape[1] - 1))), free)
    b = chance.random((free.size, 2)) * free.reshape(-1, 1)
    whole, parts = WholeFactor(shape).factorise(values), GridFactor(shape).factorise(values)
    assert np.allclose(whole.solve(b), parts.solve(b))
    again = b, np.arange(free.size)
    assert np.allclose(
        whole.forward(b).T @ whole.forward_again(*again), parts.forward(b).T @ parts.forward_again(*again)
    )
