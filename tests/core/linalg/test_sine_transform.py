import numpy as np
import pytest

from core.linalg.sine_transform import Sines


@pytest.mark.parametrize("count", [2, 3, 30, 31, 701, 720])
@pytest.mark.parametrize("axis", [-2, -1])
def test_sums_are_those_of_the_definition(count: int, axis: int) -> None:
    coefficients = np.random.default_rng(0).normal(size=(count - 1, 3))
    turns = np.pi * np.outer(np.arange(count + 1), np.arange(1, count)) / count
    table = coefficients if axis == -2 else coefficients.T
    found = Sines(count).sums(table, axis=axis)
    assert np.allclose(found if axis == -2 else found.T, np.sqrt(2 / count) * np.sin(turns) @ coefficients, atol=1e-9)
