"""Solve for what a nearly linear process has to be asked for, from what it gave before  [Anderson 1965].

A process h answers x by h(x), close to x. Wanted is h(x) = g. From pairs (Δx, Δh) of steps taken before, the part of
what is missed, f = g - h(x), that they explain is made up for by what caused it, and the rest is asked for as it is:

    x + Δx θ + (f - Δh θ),      θ = argmin |f - Δh θ|.
"""

import numpy as np

from core.mapping.jacobians import Complexes

_PAIRS = 6
"""So many steps are remembered."""


class Secants:
    """The last steps of one process; they stay of use while nothing but constants of it changes."""

    def __init__(self) -> None:
        self._steps: list[tuple[Complexes, Complexes]] = []
        self._last: tuple[Complexes, Complexes] | None = None
        """What was asked for last, and what it gave."""
        self._before: tuple[Complexes, Complexes] | None = None
        """The same for the goal before that."""
        self._is_as_before = False
        """Whether the process has the same constants as then."""

    def begin(self, goal: Complexes, noise: float) -> Complexes:
        """Return what to ask for first (k,), for another goal or where constants of the process have changed.

        It goes on as from the goal before the last one to the last; what was given is known but for some `noise`.
        """
        last, before = self._last, self._before
        self._before, self._is_as_before = last, False
        if last is None:
            return goal.copy()
        missed = goal - last[1]
        if before is None:
            return np.asarray(last[0] + missed)
        dx, dh = last[0] - before[0], last[1] - before[1]
        theta = np.vdot(dh, missed) / (np.vdot(dh, dh) + noise**2)
        return np.asarray(last[0] + dx * theta + (missed - dh * theta))

    def learn(self, x: Complexes, given: Complexes) -> None:
        """Take it that asking for x (k,) has given h(x)."""
        if self._last is not None and self._is_as_before:
            self._steps = [*self._steps[1 - _PAIRS :], (x - self._last[0], given - self._last[1])]
        self._last, self._is_as_before = (x.copy(), given), True

    def step(self, goal: Complexes) -> Complexes:
        """Return what to ask for next (k,)."""
        assert self._last is not None
        x, missed = self._last[0], goal - self._last[1]
        if not self._steps:
            return np.asarray(x + missed)
        dx, dh = (np.stack(part, axis=1) for part in zip(*self._steps, strict=True))
        theta = np.linalg.lstsq(dh, missed, rcond=1e-10)[0]
        return np.asarray(x + dx @ theta + (missed - dh @ theta))
