"""Conjugate gradients on a grid, preconditioned by one V-cycle of multigrid [Tatebe 1993]."""

import math

import moderngl
import numpy as np

from app.render.gpu import release
from app.render.solver.hierarchy import Hierarchy
from core.arrays import Floats

_MOST_STEPS = 30
"""Steps after which a solve ends, however near it is: single precision gets no nearer."""
_ROUNDS = 3
"""Times that what is left is worked out from the solution: steps only add up what they take of it."""
_ROUNDING = 8 * float(np.finfo(np.float32).eps)
"""Share of the first correction that rounding takes of those sums."""


class Multigrid:
    """Solves the system of a grid for two right-hand sides at once, x and y, in single precision.

    A V-cycle smooths twice before and twice after the correction from the coarser grid. What it would add to the
    solution says how far that is off: a solve ends where no node would move by more than is asked for.
    """

    def __init__(self, context: moderngl.Context, shape: tuple[int, int]) -> None:
        self.hierarchy = Hierarchy(context, shape)
        self._finest = self.hierarchy.levels[0]
        vectors, finest = 8 * self.hierarchy.count, 8 * self._finest.size
        self._correction, self._left, self._between = (context.buffer(reserve=vectors) for _ in range(3))
        self._direction, self.load = (context.buffer(reserve=finest) for _ in range(2))
        across, down = self._finest.tiles
        self._sums = context.buffer(reserve=16 + 8 * across * down)
        self._context = context
        self.steps = 0
        """Steps of all solves so far."""

    def solution(self) -> moderngl.Buffer:
        """Return room for a solution, 0."""
        return self._context.buffer(np.zeros(2 * self._finest.size, np.float32).tobytes())

    def solve(self, load: Floats | None, v: moderngl.Buffer, *, within: float, share: bool = False) -> None:
        """Improve the solution `v` for a load (N, 2), or what `load` has, until it is off by no more than `within`.

        Where `share` is set, that is a share of the largest value of the solution. Raises `ArithmeticError` where the
        driver finds nothing finite.
        """
        if load is not None:
            self.load.write(np.ascontiguousarray(load, np.float32))
        self._bind(v)
        if not self._begin() > 0:  # 0 is nearer, or the last solution was not finite
            v.clear()
            self._begin()
        first = largest = self._correct()
        bound = within * (first if share else 1.0)
        for _ in range(_ROUNDS):
            if largest <= bound:
                return
            self._descend(bound)
            if first * _ROUNDING < bound:
                return
            self._begin()
            first = largest = self._correct()

    def _bind(self, v: moderngl.Buffer) -> None:
        self.hierarchy.bind()
        held = self._correction, self._left, self._between, self._direction, v, self._sums
        for place, buffer in enumerate(held, 1):
            buffer.bind_to_storage_buffer(place)

    def _begin(self) -> float:
        """Work out what the solution leaves; return by how much that is less than the load: |load|² - |left|²."""
        self.load.bind_to_storage_buffer(7)
        self.hierarchy.run("start", self._finest)
        self.hierarchy.bind_bottom()
        self._total()
        gained, *_ = self._read_sums()
        self._sums.write(bytes(16))  # no last direction
        return gained

    def _correct(self) -> float:
        """Put what is left, preconditioned, into the correction; return its largest value."""
        self._cycle()
        self.hierarchy.run("product", self._finest)
        self._total()
        energy, *_, largest = self._read_sums()
        if not math.isfinite(energy):
            raise ArithmeticError("a solve on the GPU has no finite solution")
        return largest

    def _descend(self, bound: float) -> None:
        """Take steps until no node would move by more than `bound`."""
        for _ in range(_MOST_STEPS):
            self._run_line("direction")
            self.hierarchy.run("apply", self._finest)
            self._total("STEP_FOUND")
            self._run_line("advance")
            self.steps += 1
            if self._correct() <= bound:
                return

    def _run_line(self, name: str) -> None:
        self.hierarchy.run(name, self._finest, (self._finest.rows_of_threads, 1))

    def _total(self, *defined: str) -> None:
        """Bring the sums of all groups together."""
        across, down = self._finest.tiles
        self.hierarchy.run("total", self._finest, (1, 1), defined, parts=across * down)

    def _read_sums(self) -> tuple[float, ...]:
        """Return r* M r, the step, the share of the last direction and the largest correction."""
        return tuple(np.frombuffer(self._sums.read(16), np.float32).tolist())

    def _cycle(self) -> None:
        """Run one V-cycle."""
        *others, bottom = self.hierarchy.levels
        run = self.hierarchy.run
        for level, coarser in zip(others, self.hierarchy.levels[1:], strict=True):
            run("smooth_first", level)
            run("residual", level)
            run("restrict", level, coarser.tiles)
        run("bottom", bottom, (-(-bottom.size // 64), 1))
        for level in reversed(others):
            run("prolong", level)
            run("smooth", level)
            run("smooth", level, None, ("LAST",))

    def release(self) -> None:
        """Free the GPU objects."""
        vectors = self._correction, self._left, self._between, self._direction, self.load
        release(self.hierarchy, *vectors, self._sums)
