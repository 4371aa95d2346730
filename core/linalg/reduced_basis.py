"""A linear map that is asked for much the same again and again, answered by what it gave before.

Whatever was asked for is kept as an orthonormal basis, with what the map F makes of it (a reduced basis, chosen by what
it leaves: Prud'homme et al. 2002). Of x the part that the basis spans,

    x = Σ wᵢ qᵢ + r,      F x ≈ Σ wᵢ F qᵢ,

is a product with a table. The rest r is measured: where any of it may matter, F is evaluated for it, and it is kept
too. Less than that is learnt when there is time, since what is asked for next mostly has more of it.
"""

from collections.abc import Callable

import numpy as np

from core.arrays import Floats
from core.linalg.cubic_convolution import Complexes

_MOST_NUMBERS = 2_000_000
"""In a table, of 16 MB."""
_WORTH_LEARNING = 0.3
"""Share of what is let go of: of less more is learnt in vain, of more more is waited for."""


class ReducedBasis:
    """What is known of a linear map F of complex numbers.

    Parameters
    ----------
    evaluate
        F x (N,) for x (n,).
    off
        By how much each number of x may be off (n,).
    """

    def __init__(self, evaluate: Callable[[Complexes], Complexes], off: Floats) -> None:
        self._evaluate, self._off = evaluate, off
        self.count = 0
        """Of the basis."""
        self._duals = np.empty((0, len(off)), np.complex128)
        """The qᵢ, conjugate, in units of what may be off."""
        self._peaks = np.empty(0)
        """The largest number in each."""
        self._given = np.empty((0, 0), np.complex64)
        """F qᵢ."""
        self._shares = np.empty(0, np.complex128)
        """Those that they have of the last x,"""
        self._rest = np.zeros(len(off), np.complex128)
        """and what they leave."""
        self._has_grown = False
        """Whether any of it was taken in."""

    @property
    def is_new(self) -> bool:
        """Whether the last x had anything beyond what was known before it."""
        return self._has_grown or self._is_left(_WORTH_LEARNING)

    def answer(self, x: Complexes) -> Complexes:
        """Return F x (N,)."""
        self._shares, self._rest = self._split(x / self._off)
        self._has_grown = False
        if self._is_left(1) or not self.count:
            self._take()
        return np.asarray(self._shares.astype(np.complex64) @ self._given[: self.count], np.complex128)

    def learn(self) -> None:
        """Take in what the last x had beyond what was known."""
        if self._is_left(_WORTH_LEARNING):
            self._take()

    def _is_left(self, share: float) -> bool:
        return bool(np.abs(self._rest).max(initial=0) > share)

    def _split(self, x: Complexes) -> tuple[Complexes, Complexes]:
        """Return the shares that the qᵢ have of x, and what they leave."""
        duals = self._duals[: self.count]
        shares = duals @ x
        return shares, x - (shares.conj() @ duals).conj()

    def _take(self) -> None:
        """Take in what is left of the last x, without room in the place of what that has least of."""
        if self.count and self.count == len(self._given):
            place = int((np.abs(self._shares) * self._peaks).argmin())
            self._rest = self._rest + self._shares[place] * self._duals[place].conj()
            self._duals[place] = 0
        else:
            place, self._shares = self.count, np.append(self._shares, 0)
        _, rest = self._split(self._rest)  # again: rounding had left some of what is known
        length = float(np.linalg.norm(rest)) or 1.0
        given = self._evaluate(rest / length * self._off)
        if not len(self._given):
            most = max(_MOST_NUMBERS // max(len(given), 1), 1)
            self._given = np.empty((most, len(given)), np.complex64)
            self._duals, self._peaks = np.empty((most, len(rest)), np.complex128), np.empty(most)
        self._duals[place], self._given[place] = rest.conj() / length, given
        self._peaks[place], self._shares[place] = np.abs(rest).max(initial=0) / length, length
        self._rest = np.zeros_like(rest)
        self.count, self._has_grown = len(self._shares), True
