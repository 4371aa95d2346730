"""Live answers on large grids by what solves them faster than the processor, where there is such a thing."""

import logging
from collections.abc import Callable
from typing import TypeAlias

from core.arrays import WeftError
from core.document.document import Document
from core.document.map_solver import MapSolver
from core.document.straight_lines import PictureLines
from core.linalg.grid_solver import GridSolver
from core.mapping.result import Warped

MakeSolver: TypeAlias = Callable[[tuple[int, int]], GridSolver]
"""Returns what solves the system of a grid of that shape."""


class GpuFrames:
    """Answers while something moves; everything but its making runs on the live thread."""

    def __init__(self, find: Callable[[], MakeSolver | None], lines: PictureLines) -> None:
        self._find, self._lines = find, lines
        self._make: MakeSolver | None = None
        self._solver = MapSolver(lines=lines)
        self._learnt: Warped | None = None
        self._has_failed = False

    def frame(self, document: Document, settled: tuple[Document, Warped] | None) -> Warped | None:
        """Return the linear answer; None where only the processor can give one.

        Handles move the picture of the answer that has `settled`, where the documents differ by handles only.
        """
        make = None if self._has_failed else self._find()
        if make is None:
            return None
        if make != self._make:
            self._make, self._solver, self._learnt = make, MapSolver(analyse=make, lines=self._lines), None
        try:
            if settled is not None and settled[1] is not self._learnt:
                self._solver.learn(*settled)
                self._learnt = settled[1]
            found = self._solver.frame(document)
            self._solver.look_ahead()
            return found
        except WeftError:
            raise  # what is wrong is the document
        except Exception as fault:
            logging.getLogger("weft").error("the map is not solved on the GPU any more", exc_info=fault)
            self._has_failed = True
            return None
