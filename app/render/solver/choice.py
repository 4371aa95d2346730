"""Whether the GPU solves the mapping's system, and the solver that does."""

from collections.abc import Callable

from app.render import gpu
from app.render.gpu import COMPUTE, is_software, release
from app.render.solver.grid_multigrid import GridMultigrid
from core.arrays import WeftError


class GpuSolver:
    """The solver of one thread, in that thread's context; one grid's at a time."""

    def __init__(self) -> None:
        self._held: GridMultigrid | None = None

    def find(self, preferred: str) -> Callable[[tuple[int, int]], GridMultigrid] | None:
        """Return what makes a solver, None where there is none or, neither "auto" nor "gpu", none is `preferred`."""
        if preferred not in ("auto", "gpu"):
            return None
        try:
            context = gpu.standalone()
        except WeftError:
            return None
        # On a software driver the processor's own factor is faster.
        lacks = context.version_code < COMPUTE or (preferred == "auto" and is_software(context))
        return None if lacks else self._make

    def _make(self, shape: tuple[int, int]) -> GridMultigrid:
        """Return a solver for grids of a shape; the one before is spent."""
        release(self._held)
        self._held = GridMultigrid(gpu.standalone(), shape)
        return self._held
