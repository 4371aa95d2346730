"""The least squares of fitting features between outline nodes, beside SciPy's."""

import numpy as np
import pytest
from scipy.optimize import nnls

from core.mapping.nonnegative import nonnegative


@pytest.mark.parametrize("shape", [(5, 1), (5, 3), (5, 40), (30, 26), (60, 200)])
def test_what_is_found_is_what_scipy_finds(shape: tuple[int, int]) -> None:
    for seed in range(10):
        chance = np.random.default_rng(seed)
        E, f = chance.normal(0, 1, shape), chance.normal(0, 1, shape[0])
        u, distance = nonnegative(E, f)
        expected, least = nnls(E, f)
        assert (u >= 0).all()
        np.testing.assert_allclose(distance, least, atol=1e-9)
        np.testing.assert_allclose(E @ u, E @ expected, atol=1e-8)


def test_columns_that_repeat_and_targets_out_of_reach_have_an_answer() -> None:
    E = np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    u, distance = nonnegative(E, np.array([2.0, 0.0]))
    assert u[:2].sum() == pytest.approx(2)
    assert distance == pytest.approx(0)
    u, distance = nonnegative(E, np.array([-3.0, 4.0]))
    assert (u == 0).all()
    assert distance == pytest.approx(5)
