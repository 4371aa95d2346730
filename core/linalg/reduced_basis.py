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
        self._given = np.empty((0, 0), np.complex64)
        """F qᵢ."""
        self._rest = np.zeros(len(off), np.complex128)
        """What they leave of the last x."""

    def answer(self, x: Complexes) -> Complexes:
        """Return F x (N,)."""
        shares, self._rest = self._split(x / self._off)
        if self._is_left(1) or not self.count:
            shares = self._take(shares)
        return np.asarray(shares.astype(np.complex64) @ self._given[: self.count], np.complex128)

    def learn(self) -> None:
        """Take in what the last x had beyond what was known, where there is room."""
        if self.count < len(self._given) and self._is_left(_WORTH_LEARNING):
            self._take(np.empty(self.count, np.complex128))

    def _is_left(self, share: float) -> bool:
        return bool(np.abs(self._rest).max(initial=0) > share)

    def _split(self, x: Complexes) -> tuple[Complexes, Complexes]:
        """Return the shares that the qᵢ have of x, and what they leave."""
        duals = self._duals[: self.count]
        shares = duals @ x
        return shares, x - (shares.conj() @ duals).conj()

    def _take(self, shares: Complexes) -> Complexes:
        """Take in what is left of an x with these shares; return its shares of all. Without room, begin anew."""
        if self.count and self.count == len(self._given):
            self._rest = self._rest + (shares.conj() @ self._duals).conj()
            self.count, shares = 0, shares[:0]
        _, rest = self._split(self._rest)  # again: rounding had left some of what is known
        length = float(np.linalg.norm(rest)) or 1.0
        given = self._evaluate(rest / length * self._off)
        if not len(self._given):
            most = max(_MOST_NUMBERS // max(len(given), 1), 1)
            self._given = np.empty((most, len(given)), np.complex64)
            self._duals = np.empty((most, len(rest)), np.complex128)
        self._duals[self.count], self._given[self.count] = rest.conj() / length, given
        self._rest = np.zeros_like(rest)
        self.count += 1
        return np.append(shares, complex(length))
