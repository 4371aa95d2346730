"""What a nearly linear process has to be asked for, from what it gave before."""

import numpy as np
import pytest

from core.mapping.handles.secants import Secants
from core.mapping.jacobians import Complexes

MIXING = np.array([[0.6, 0.3j, 0.1], [-0.2, 0.5, 0.2], [0.1, -0.1j, 0.7]])


def answer(x: Complexes) -> Complexes:
    """Return what a process that mixes what it is asked for gives."""
    return np.asarray(MIXING @ x + 0.5)


def test_it_comes_to_what_is_wanted() -> None:
    secants, goal = Secants(), np.array([3 + 1j, -2.0, 5j])
    asked = secants.begin(goal, 0.0)
    for _ in range(6):
        secants.learn(asked, answer(asked))
        asked = secants.step(goal)
    assert answer(asked) == pytest.approx(goal, abs=1e-6)


def test_tiny_steps_say_nothing_of_a_long_way() -> None:
    """Steps of a process that has come to its goal are rounding, mostly; then it is to go many pixels."""
    secants, goal, noise = Secants(), np.array([3 + 1j, -2.0, 5j]), np.random.default_rng(0)
    asked = goal.copy()
    for _ in range(3):
        asked = asked + 1e-4 * noise.normal(size=3)
        secants.learn(asked, np.asarray(goal + 1e-7 * noise.normal(size=3), np.complex128))
    assert np.abs(secants.step(goal + 20) - asked).max() < 25
