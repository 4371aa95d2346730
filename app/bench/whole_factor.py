"""A grid's system factorised by CHOLMOD all at once, to compare the factor that is renewed in parts with."""

import numpy as np

from core.arrays import Floats, Ints
from core.linalg.factor import Factor
from core.linalg.laplacian import find_stored, pattern
from core.linalg.multifrontal import GridFactor, HalfColumns


class WholeFactor(GridFactor):
    """The same, without what is kept of its parts."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self._stored = find_stored(shape)
        self._factor = Factor(pattern(shape), pattern_only=True)

    def factorise(self, values: Floats) -> "WholeFactor":
        """Factorise new values (R, C, 3) and return the factor itself."""
        self._factor.factorise(values[self._stored])
        return self

    def solve(self, b: Floats) -> Floats:
        """Solve A x = b for b (N, k)."""
        return self._factor.solve(b)

    def forward(self, b: Floats, nodes: Ints | None = None, asked: Ints | None = None) -> HalfColumns:
        """Return the first half of a solve."""
        return HalfColumns(np.arange(self._factor.size), self._factor.forward(b), self._factor.size)

    def forward_again(self, values: Floats, nodes: Ints) -> Floats:
        """Return the first half of a solve."""
        b = np.zeros((self._factor.size, values.shape[1]))
        b[nodes] = values
        return self._factor.forward(b)

    def backward(self, y: Floats) -> Floats:
        """Return the second half."""
        return self._factor.backward(y)
