"""Solve for what a nearly linear process has to be asked for, from what it gave before  [Anderson 1965].

A process h answers x by h(x), close to x. Wanted is h(x) = g. From pairs (Δx, Δh) of steps taken before, the part of
what is missed, f = g - h(x), that they explain is made up for by what caused it, and the rest is asked for as it is:

    x + Δx θ + (f - Δh θ),      θ = argmin |f - Δh θ|.
"""

import numpy as np

from core.mapping.jacobians import Complexes
from core.mapping.tolerances import LITTLE

_PAIRS = 6
"""So many steps are remembered."""
_GOALS = 3
"""So many of the ways between goals."""


class Secants:
    """The last steps of one process; they stay of use while nothing but constants of it changes."""

    def __init__(self) -> None:
        self._steps: list[tuple[Complexes, Complexes]] = []
        self._last: tuple[Complexes, Complexes] | None = None
        """What was asked for last, and what it gave."""
        self._goal: Complexes | None = None
        self._goals: list[tuple[Complexes, Complexes]] = []
        """What each of the goals before it was asked for at last, and what that gave."""
        self._is_as_before = False
        """Whether the process has the same constants as then."""

    def begin(self, goal: Complexes, noise: float) -> Complexes:
        """Return what to ask for first (k,), for another goal or where constants of the process have changed.

        What lay between the last goals tells of what lies between the last one and this; it is known but for `noise`.
        """
        self._is_as_before, before, self._goal = False, self._goal, goal.copy()
        if self._last is None:
            return goal.copy()
        if before is not None and not np.array_equal(before, goal):
            self._goals = [*self._goals[-_GOALS:], self._last]
        x, missed = self._last[0], goal - self._last[1]
        if len(self._goals) < 2:
            return np.asarray(x + missed)
        dx, dh = (np.diff(part, axis=0).T for part in zip(*self._goals, strict=True))
        pull, f = (np.concatenate([part.real, part.imag]) for part in (dh, missed))
        theta = np.linalg.solve(pull.T @ pull + noise**2 * np.eye(pull.shape[1]), pull.T @ f)
        return np.asarray(x + dx @ theta + (missed - dh @ theta))

    def learn(self, x: Complexes, given: Complexes) -> None:
        """Take it that asking for x (k,) has given h(x)."""
        if self._last is not None and self._is_as_before and not np.array_equal(x, self._last[0]):
            self._steps = [*self._steps[1 - _PAIRS :], (x - self._last[0], given - self._last[1])]
        self._last, self._is_as_before = (x.copy(), given), True

    def step(self, goal: Complexes) -> Complexes:
        """Return what to ask for next (k,)."""
        assert self._last is not None
        x, missed = self._last[0], goal - self._last[1]
        if not self._steps:
            return np.asarray(x + missed)
        dx, dh = (np.stack(part, axis=1) for part in zip(*self._steps, strict=True))
        # A step tells nothing of one that is far longer: none counts that went less than a little of what is missing.
        noise = LITTLE * np.abs(missed).max() * np.eye(dh.shape[1])
        theta = np.linalg.lstsq(np.concatenate([dh, noise]), np.append(missed, np.zeros(len(noise))), rcond=None)[0]
        return np.asarray(x + dx @ theta + (missed - dh @ theta))
