"""A linear map that is asked for much the same again and again."""

import numpy as np
import pytest

from core.linalg import reduced_basis
from core.linalg.reduced_basis import ReducedBasis
from core.mapping.jacobians import Complexes

OFF = 1e-3
F = np.random.default_rng(0).normal(size=(30, 40))
GAIN = np.abs(F).sum(axis=1).max()


class Map:
    """F, and how often it is evaluated."""

    def __init__(self) -> None:
        self.count = 0

    def __call__(self, x: Complexes) -> Complexes:
        self.count += 1
        return np.asarray(F @ x)


def path(t: float) -> Complexes:
    """Return what is asked for at a time: a smooth path through all dimensions."""
    return np.asarray(200 * np.exp(1j * np.arange(40) * t / 40))


def test_what_is_smooth_is_answered_from_a_few_evaluations_and_off_by_as_little_as_was_allowed() -> None:
    evaluate = Map()
    basis = ReducedBasis(evaluate, np.full(40, OFF))
    for t in np.linspace(0, 2, 200):
        assert np.abs(basis.answer(path(t)) - F @ path(t)).max() < OFF * GAIN
    assert evaluate.count == basis.count < 12


def test_what_is_learnt_in_time_is_not_waited_for() -> None:
    evaluate = Map()
    basis = ReducedBasis(evaluate, np.full(40, OFF))
    waited = []
    for t in np.linspace(0, 2, 200):
        before = evaluate.count
        basis.answer(path(t))
        waited.append(evaluate.count > before)
        basis.learn()
    assert sum(waited) < 6
    assert not any(waited[100:])


def test_numbers_may_be_off_by_their_own() -> None:
    evaluate, off = Map(), np.append(np.full(39, 1.0), OFF)
    basis = ReducedBasis(evaluate, off)
    first, last = 0.1 * np.eye(40, dtype=np.complex128)[[0, 39]]
    x = path(1) * (off == 1)
    basis.answer(x)
    basis.answer(x + first)
    assert evaluate.count == 1
    assert np.abs(basis.answer(x + last) - F @ (x + last)).max() < (np.abs(F) @ off).max()
    assert evaluate.count == 2


def test_without_room_what_is_new_takes_the_place_of_what_is_asked_for_least(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reduced_basis, "_MOST_NUMBERS", 4 * 30)
    evaluate, each = Map(), np.eye(40, dtype=np.complex128)
    basis = ReducedBasis(evaluate, np.full(40, OFF))
    mixtures = np.random.default_rng(0).uniform(1, 5, (37, 3)) @ each[:3]
    for x in [*each[:3], *(mixtures + 0.1 * each[3:])]:
        assert np.abs(basis.answer(x) - F @ x).max() < OFF * GAIN
    assert basis.count == 4
    assert evaluate.count == 40
    for mixture in mixtures:
        basis.answer(mixture + 0.1 * each[-1])
    assert evaluate.count == 40


def test_a_path_that_is_too_long_for_the_table_is_answered_as_nearly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reduced_basis, "_MOST_NUMBERS", 4 * 30)
    basis = ReducedBasis(Map(), np.full(40, OFF))
    for t in np.linspace(0, 6, 100):
        assert np.abs(basis.answer(path(t)) - F @ path(t)).max() < OFF * GAIN
        basis.learn()
    assert basis.count == 4


def test_it_tells_whether_what_it_was_asked_for_last_was_new() -> None:
    basis = ReducedBasis(Map(), np.full(40, OFF))
    found = []
    for t in (1, 1, 2, 2):
        basis.answer(path(t))
        found.append(basis.is_new)
    basis.answer(path(1) + OFF / 2 * np.eye(40)[3])
    found.append(basis.is_new)
    basis.learn()
    basis.answer(path(1) + OFF / 2 * np.eye(40)[3])
    found.append(basis.is_new)
    assert found == [True, False, True, False, True, False]


def test_nothing_gives_nothing() -> None:
    basis = ReducedBasis(Map(), np.full(40, OFF))
    assert not basis.answer(np.zeros(40, np.complex128)).any()
    np.testing.assert_allclose(basis.answer(path(1)), F @ path(1), atol=OFF * GAIN)
