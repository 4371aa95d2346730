"""What solves the system of a grid: the matrix of FAT eq. 10, whatever way it is solved."""

from typing import Any, Protocol

from core.arrays import Floats, Ints


class HalfSolved(Protocol):
    """Loads b (N, k) after the first half of a solve: of two of them, a.T @ c is bᵀ A⁻¹ d."""

    @property
    def T(self) -> Any:  # noqa: N802
        """What multiplies others, or what `GridSolver.forward_again` gave, from the left."""

    def __matmul__(self, shares: Any, /) -> Any:
        """Return their combinations by `shares` (k, 2), which can be added to what `forward_again` gave."""

    def __getitem__(self, columns: Any, /) -> Any:
        """Return some of them."""


class GridSolver(Protocol):
    """Solves A x = b for a symmetric positive definite matrix with the pattern of `laplacian.pattern`.

    Nodes of the outline are to be uncoupled from all others, with the equation x = 0: every b is to be 0 there.
    """

    def factorise(self, values: Floats) -> object:
        """Take new values (R, C, 3) of `laplacian.node_values`."""

    def solve(self, b: Floats) -> Floats:
        """Solve A x = b for b (N, 2)."""

    def forward(self, b: Floats, nodes: Ints | None = None) -> HalfSolved:
        """Return the first half of a solve for b (N, k), which is 0 but at `nodes`."""

    def forward_again(self, b: Floats) -> Floats:
        """Return the first half of a solve for b (N, 2), which is often much like the last one."""

    def backward(self, y: Floats) -> Floats:
        """Return the second half (N, 2)."""
