"""Least squares with unknowns that must not be negative  [Lawson & Hanson 1974, ch. 23]."""

import numpy as np

from core.arrays import Bools, Floats

_ROUNDS = 3
"""Times the number of unknowns: how many are let go of at most."""


def nonnegative(E: Floats, f: Floats) -> tuple[Floats, float]:
    """Return the u >= 0 (n,) that minimises |E u - f| for E (m, n), and that distance.

    All u begin at 0; the one whose growth lessens the distance most is let go of, one after the other, and held at 0
    again where it would become negative.
    """
    u, free = np.zeros(E.shape[1]), np.zeros(E.shape[1], bool)
    slack = 10 * max(E.shape) * np.finfo(np.float64).eps * np.abs(E).sum(axis=0).max(initial=0.0)
    for _ in range(_ROUNDS * E.shape[1]):
        gain = np.where(free, 0.0, E.T @ (f - E @ u))
        best = int(np.argmax(gain))
        if gain[best] <= slack:
            break
        free[best] = True
        wanted = _least_squares(E, f, free)
        while (wanted[free] <= 0).any():
            low = np.flatnonzero(free & (wanted <= 0))
            shares = u[low] / (u[low] - wanted[low])
            u += shares.min() * (wanted - u)
            free[low[shares == shares.min()]] = False
            u[~free] = 0
            wanted = _least_squares(E, f, free)
        u = wanted
    return u, float(np.linalg.norm(E @ u - f))


def _least_squares(E: Floats, f: Floats, free: Bools) -> Floats:
    """Return the minimiser whose unknowns are 0 unless they are free."""
    found = np.zeros(E.shape[1])
    found[free] = np.linalg.lstsq(E[:, free], f)[0]
    return found
