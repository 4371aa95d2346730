"""Sparse Cholesky factors: analyse a pattern once, factorise values often, solve more often still.

The back end is CHOLMOD, through CVXOPT, in its supernodal form P A Pᵀ = L Lᴴ.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.arrays import Floats, Ints, SingularSystemError
from core.linalg.cholmod import cholmod, cvxopt
from core.tracing import span

if TYPE_CHECKING:
    from scipy import sparse

_FORWARD, _BACKWARD, _PERMUTE, _UNPERMUTE = 4, 5, 7, 8


class Entries(NamedTuple):
    """n entries on and below the diagonal of a symmetric matrix; those at one place are added up."""

    rows: Ints
    columns: Ints
    values: Floats
    size: int
    """Of the matrix, along either side."""


class Factor:
    """The Cholesky factor of a symmetric (or Hermitian) positive definite matrix.

    Parameters
    ----------
    matrix
        (n, n), sparse, or its entries. Only its lower triangle is read. Entries that are zero now but may not stay so
        must be stored.
    pattern_only
        Whether the matrix is but analysed: its values are factorised later, before the first solve.

    Raises
    ------
    SingularSystemError
        If the matrix is not positive definite; `nodes` names unknowns without any equation, where there are such.
    """

    def __init__(self, matrix: "sparse.sparray | sparse.spmatrix | Entries", *, pattern_only: bool = False) -> None:
        lower = matrix if isinstance(matrix, Entries) else _lower_triangle(matrix)
        self.size = lower.size
        self._scalar = np.complex128 if np.iscomplexobj(lower.values) else np.float64
        code, values = ("z" if self._scalar is np.complex128 else "d"), lower.values.astype(self._scalar)
        self._matrix = cvxopt.spmatrix(cvxopt.matrix(values), lower.rows, lower.columns, (self.size, self.size), code)
        starts, rows, stored = self._matrix.CCS
        self.indices: Ints = np.array(rows, np.int64).ravel()
        """Row of each stored entry of the lower triangle, column by column."""
        self.starts: Ints = np.array(starts, np.int64).ravel()
        cholmod.options["supernodal"] = 2
        with span("analyse", unknowns=self.size):
            self._factor = cholmod.symbolic(self._matrix)
        if not pattern_only:
            self.factorise(np.array(stored).ravel())

    def factorise(self, values: NDArray[Any]) -> "Factor":
        """Factorise new values of the lower triangle, column by column, and return the factor itself."""
        self._matrix.V = cvxopt.matrix(np.ascontiguousarray(values, self._scalar))
        try:
            with span("factor", unknowns=self.size):
                cholmod.numeric(self._matrix, self._factor)
        except ArithmeticError:
            raise self._singular(np.asarray(values)) from None
        return self

    def _singular(self, values: NDArray[Any]) -> SingularSystemError:
        diagonal = np.real(values[self.starts[:-1]])
        nodes = np.flatnonzero(~(diagonal > 0))
        if nodes.size:
            return SingularSystemError(f"{nodes.size} of {self.size} unknowns have no equation", nodes)
        return SingularSystemError(f"a system of {self.size} unknowns has no unique solution")

    def solve(self, b: NDArray[Any], out: NDArray[Any] | None = None) -> NDArray[Any]:
        """Solve A x = b for b (n,) or (n, k)."""
        return self._run(b, out, 0)

    def forward(self, b: NDArray[Any]) -> NDArray[Any]:
        """Return L⁻¹ P b, the first half of a solve: forward(a)ᴴ forward(b) = aᴴ A⁻¹ b."""
        return self._run(b, None, _PERMUTE, _FORWARD)

    def backward(self, y: NDArray[Any]) -> NDArray[Any]:
        """Return Pᵀ L⁻ᴴ y, the second half: backward(forward(b)) = A⁻¹ b."""
        return self._run(y, None, _BACKWARD, _UNPERMUTE)

    def _run(self, b: NDArray[Any], out: NDArray[Any] | None, *systems: int) -> NDArray[Any]:
        columns = np.asarray(b, self._scalar).reshape(self.size, -1)
        if columns.shape[1] == 0:
            return np.zeros(b.shape, self._scalar)
        work = cvxopt.matrix(columns)
        for system in systems:
            cholmod.solve(self._factor, work, sys=system)
        result = np.asarray(work).reshape(b.shape)
        if out is None:
            return result
        out[...] = result
        return out

    def __repr__(self) -> str:
        kind = "complex" if self._scalar is np.complex128 else "real"
        return f"Factor({self.size} unknowns, {len(self.indices)} entries, {kind}, CHOLMOD supernodal)"


def _lower_triangle(matrix: "sparse.sparray | sparse.spmatrix") -> Entries:
    # Systems that are put together without SciPy do not wait for it to load.
    from scipy import sparse

    lower = sparse.coo_array(sparse.csc_array(sparse.tril(matrix)))
    return Entries(lower.row.astype(np.int64), lower.col.astype(np.int64), lower.data, lower.shape[0])
