"""Sparse Cholesky factors: analyse a pattern once, factorise values often, solve more often still.

The back end is CHOLMOD, through CVXOPT, in its supernodal form P A Pᵀ = L Lᴴ.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.arrays import Floats, Ints, SingularSystemError
from core.linalg.beside import process_of_thread
from core.linalg.cholmod import cholmod, cvxopt
from core.tracing import span

if TYPE_CHECKING:
    from scipy import sparse

_LARGE = 4000
"""Unknowns from which on a factor may take more than some milliseconds."""
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

    Off the main thread a large one is in a process of its own: CHOLMOD holds the interpreter's lock while it works.

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
        lower = matrix if isinstance(matrix, Entries) else lower_triangle(matrix)
        self.size = lower.size
        process = process_of_thread() if self.size >= _LARGE else None
        self._ask: Callable[..., Any]
        with span("analyse", unknowns=self.size, beside=process is not None):
            if process is None:
                here = Cholmod(lower)
                self._ask = lambda method, *arguments: getattr(here, method)(*arguments)
            else:
                self._ask = process.make(Cholmod, lower).ask
        if not pattern_only:
            with span("factor", unknowns=self.size):
                self._ask("factorise")

    @property
    def indices(self) -> Ints:
        """Row of each stored entry of the lower triangle, column by column."""
        return np.asarray(self._ask("indices"))

    def factorise(self, values: NDArray[Any]) -> "Factor":
        """Factorise new values of the lower triangle, column by column, and return the factor itself."""
        with span("factor", unknowns=self.size):
            self._ask("factorise", values)
        return self

    def solve(self, b: NDArray[Any]) -> NDArray[Any]:
        """Solve A x = b for b (n,) or (n, k)."""
        return np.asarray(self._ask("run", b, 0))

    def forward(self, b: NDArray[Any]) -> NDArray[Any]:
        """Return L⁻¹ P b, the first half of a solve: forward(a)ᴴ forward(b) = aᴴ A⁻¹ b."""
        return np.asarray(self._ask("run", b, _PERMUTE, _FORWARD))

    def backward(self, y: NDArray[Any]) -> NDArray[Any]:
        """Return Pᵀ L⁻ᴴ y, the second half: backward(forward(b)) = A⁻¹ b."""
        return np.asarray(self._ask("run", y, _BACKWARD, _UNPERMUTE))

    def __repr__(self) -> str:
        return f"Factor({self.size} unknowns, CHOLMOD supernodal)"


class Cholmod:
    """A matrix and its factor, as CVXOPT has them: what `Factor` asks for, here or in another process."""

    def __init__(self, lower: Entries) -> None:
        self.size = lower.size
        self._scalar = np.complex128 if np.iscomplexobj(lower.values) else np.float64
        code, values = ("z" if self._scalar is np.complex128 else "d"), lower.values.astype(self._scalar)
        self._matrix = cvxopt.spmatrix(cvxopt.matrix(values), lower.rows, lower.columns, (self.size, self.size), code)
        cholmod.options["supernodal"] = 2
        self._factor = cholmod.symbolic(self._matrix)

    def indices(self) -> Ints:
        """Return the row of each stored entry."""
        return np.array(self._matrix.CCS[1], np.int64).ravel()

    def factorise(self, values: NDArray[Any] | None = None) -> None:
        """Factorise the values that the matrix has, or new ones."""
        if values is not None:
            self._matrix.V = cvxopt.matrix(np.ascontiguousarray(values, self._scalar))
        try:
            cholmod.numeric(self._matrix, self._factor)
        except ArithmeticError:
            raise self._singular() from None

    def _singular(self) -> SingularSystemError:
        starts, _, values = (np.array(part).ravel() for part in self._matrix.CCS)
        nodes = np.flatnonzero(~(np.real(values[starts[:-1]]) > 0))
        if nodes.size:
            return SingularSystemError(f"{nodes.size} of {self.size} unknowns have no equation", nodes)
        return SingularSystemError(f"a system of {self.size} unknowns has no unique solution")

    def run(self, b: NDArray[Any], *systems: int) -> NDArray[Any]:
        """Apply CHOLMOD's `systems` to b (n,) or (n, k), one after the other."""
        columns = np.asarray(b, self._scalar).reshape(self.size, -1)
        if columns.shape[1] == 0:
            return np.zeros(b.shape, self._scalar)
        work = cvxopt.matrix(columns)
        for system in systems:
            cholmod.solve(self._factor, work, sys=system)
        return np.asarray(work).reshape(b.shape)


def lower_triangle(matrix: "sparse.sparray | sparse.spmatrix") -> Entries:
    """Return what of a matrix lies on and below its diagonal."""
    # Systems that are put together without SciPy do not wait for it to load.
    from scipy import sparse

    lower = sparse.coo_array(sparse.csc_array(sparse.tril(matrix)))
    return Entries(lower.row.astype(np.int64), lower.col.astype(np.int64), lower.data, lower.shape[0])
