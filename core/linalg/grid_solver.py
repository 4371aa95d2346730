"""What solves the system of a grid: the matrix of FAT eq. 10, whatever way it is solved."""

from dataclasses import dataclass
from typing import Any, Protocol

from core.arrays import Bools, Floats, Ints
from core.linalg.cubic_convolution import Complexes, Smooth


class HalfSolved(Protocol):
    """Loads b (N, k) after the first half of a solve: of two of them, a.T @ c is bᵀ A⁻¹ d."""

    @property
    def T(self) -> Any:  # noqa: N802
        """What multiplies others, or what `GridSolver.forward_again` gave, from the left."""

    def __matmul__(self, shares: Any, /) -> Any:
        """Return their combinations by `shares` (k, 2), which can be added to what `forward_again` gave."""

    def __getitem__(self, columns: Any, /) -> Any:
        """Return some of them."""


@dataclass(frozen=True, eq=False)
class Onto:
    """What a solution is added to as a displacement, and where some nodes are all the same."""

    base: Complexes
    """Positions (R, C), often the same object as in the last frame."""
    smooth: Smooth | None
    """A displacement of all nodes."""
    nodes: Ints
    at: Complexes
    """Where these nodes are (n,)."""

    def moved(self, v: Complexes) -> Complexes:
        """Return where all nodes (R, C) are, given the solution v (N,)."""
        z = v.reshape(self.base.shape) + self.base
        if self.smooth is not None:
            z += self.smooth.whole
        z.ravel()[self.nodes] = self.at
        return z


class GridSolver(Protocol):
    """Solves A x = b for a symmetric positive definite matrix with the pattern of `laplacian.pattern`.

    Nodes of the outline are to be uncoupled from all others, with the equation x = 0: every b is to be 0 there.
    """

    def factorise(self, values: Floats) -> object:
        """Take new values (R, C, 3) of `laplacian.node_values`."""

    def solve(self, b: Floats) -> Floats:
        """Solve A x = b for b (N, 2)."""

    def forward(self, b: Floats, nodes: Ints | None = None, asked: Ints | None = None) -> HalfSolved:
        """Return the first half of a solve for b (N, k), which is 0 but at `nodes`.

        What `forward_again` gives for loads at nodes that are `asked` will be multiplied with it.
        """

    def forward_again(self, values: Floats, nodes: Ints) -> Any:
        """Return the first half of a solve for a b (N, 2) with `values` (m, 2) at `nodes`, much like the last one."""

    def place(self, y: Any, onto: Onto) -> tuple[Complexes, Bools | None]:
        """Return where the second half takes all nodes (R, C), and which quads that folds, where it is known."""
