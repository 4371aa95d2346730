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


def test_without_room_it_begins_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reduced_basis, "_MOST_NUMBERS", 4 * 30)
    basis = ReducedBasis(Map(), np.full(40, OFF))
    counts = []
    for t in np.linspace(0, 6, 100):
        assert np.abs(basis.answer(path(t)) - F @ path(t)).max() < OFF * GAIN
        basis.learn()
        counts.append(basis.count)
    assert max(counts) == 4
    assert np.diff(counts).min() == -3


def test_nothing_gives_nothing() -> None:
    basis = ReducedBasis(Map(), np.full(40, OFF))
    assert not basis.answer(np.zeros(40, np.complex128)).any()
    np.testing.assert_allclose(basis.answer(path(1)), F @ path(1), atol=OFF * GAIN)
