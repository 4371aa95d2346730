"""Whether the GPU solves the mapping's system, and the solver that does."""

from collections.abc import Callable

from app.render import gpu
from app.render.gpu import release
from app.render.solver.grid_multigrid import GridMultigrid
from core.arrays import WeftError

COMPUTE = 430
"""OpenGL 4.3, the first with compute shaders."""
_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "SwiftShader", "Microsoft Basic Render")
"""In the names of drivers that draw on the processor: its own factor is faster there."""


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
        is_software = any(name in context.info["GL_RENDERER"] for name in _SOFTWARE)
        return None if context.version_code < COMPUTE or (is_software and preferred == "auto") else self._make

    def _make(self, shape: tuple[int, int]) -> GridMultigrid:
        """Return a solver for grids of a shape; the one before is spent."""
        release(self._held)
        self._held = GridMultigrid(gpu.standalone(), shape)
        return self._held
