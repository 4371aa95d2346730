"""The least squares of fitting features between outline nodes, beside SciPy's."""

import numpy as np
import pytest
from scipy.optimize import nnls

from core.mapping.junctions import _least_miss, _least_step
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


@pytest.mark.parametrize("flat", [1e-2, 1e-5, 1e-7])
def test_the_shortest_step_is_told_however_far_it_leads(flat: float) -> None:
    step = _least_step(np.array([[flat], [-1e-12]]), np.array([1.0, -1.0]))
    assert step is not None
    np.testing.assert_allclose(step, [1 / flat], rtol=1e-6)


@pytest.mark.parametrize("flat", [1e-9, 1e-12])
def test_a_step_that_rounding_hides_is_none(flat: float) -> None:
    with np.errstate(all="raise", under="ignore"):
        assert _least_step(np.array([[1.0, flat], [-1.0, flat]]), np.array([1.0, 1.0])) is None


@pytest.mark.parametrize("far", [1.0, 1e5, 1e9])
def test_a_step_far_away_is_as_exact_as_one_nearby(far: float) -> None:
    for seed in range(5):
        chance = np.random.default_rng(seed)
        G = chance.normal(0, 1, (300, 4)) + [3, 0, 0, 0]
        h = G @ (far * chance.normal(1, 1, 4)) - far * chance.uniform(0, 1, 300)
        step = _least_step(G, h)
        assert step is not None
        assert (G @ step - h).min() > -1e-9 * far


def test_what_cannot_all_be_had_is_missed_as_little_as_a_step_with_slack_says() -> None:
    for seed in range(10):
        chance = np.random.default_rng(seed)
        G, h, cost = chance.normal(0, 1, (30, 4)), chance.normal(1, 1, 30), chance.uniform(1, 1e3, 30)
        assert _least_step(G, h) is None
        slack = _least_step(np.hstack([G, np.diag(1 / cost)]), h)
        assert slack is not None
        np.testing.assert_allclose(_least_miss(G, h, cost), slack[:4], rtol=1e-6, atol=1e-8)
