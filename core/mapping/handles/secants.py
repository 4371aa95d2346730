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
        self.offset: Complexes | float = 0.0
        """By how much x was ahead of h(x) when it was tried last: where to begin for another g."""
        self._steps: list[tuple[Complexes, Complexes]] = []
        self._last: tuple[Complexes, Complexes] | None = None

    def begin(self) -> None:
        """Take no step from what was tried before: a constant of the process has changed."""
        self._last = None

    def improve(self, x: Complexes, missed: Complexes, goal: Complexes) -> Complexes:
        """Return what to ask for next (k,), when asking for x missed the goal by `missed`."""
        given = goal - missed
        if self._last is not None:
            self._steps = [*self._steps[1 - _PAIRS :], (x - self._last[0], given - self._last[1])]
        self._last, self.offset = (x.copy(), given), x - given
        if not self._steps:
            return np.asarray(x + missed)
        dx, dh = (np.stack(part, axis=1) for part in zip(*self._steps, strict=True))
        theta = np.linalg.lstsq(dh, missed, rcond=1e-10)[0]
        return np.asarray(x + dx @ theta + (missed - dh @ theta))
