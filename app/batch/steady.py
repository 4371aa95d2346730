"""Maps of a sequence that moves: of several answers for a frame, the one next to that of the frame before.

There are several where the linear answer folds (`core.mapping.injective`). Such a map depends on the frames before,
back to the last one whose linear answer does not fold, and on nothing else: who makes a later chunk works these out
again.
"""

from collections.abc import Callable, Sequence

from core.arrays import InputError
from core.document.document import Document
from core.document.map_solver import MapSolver
from core.mapping.result import Warped
from core.progress import run


class SteadySolver:
    """Answers for the frames of a batch, in any order, quickest in their own."""

    def __init__(self, frames: Sequence[int]) -> None:
        self._frames = frames
        self._solver = MapSolver()
        self._last: tuple[int, Warped] | None = None
        """Place among the frames, and the answer there."""

    def settle(self, frame: int, document_at: Callable[[int], Document]) -> Warped:
        """Return the map of the document at one of the frames.

        Raises `InputError` where there is no document at it; such a frame before it counts as none.
        """
        place = begin = self._frames.index(frame)
        document = document_at(frame)
        ahead = [document]
        while begin > 0 and not self._is_last(begin - 1) and self._solver.folds(ahead[-1]):
            try:
                ahead.append(document_at(self._frames[begin - 1]))
            except InputError:
                break
            begin -= 1
        for at in range(begin, place + 1):
            near = self._last[1] if self._last is not None and self._is_last(at - 1) else None
            self._last = at, run(self._solver.settle(ahead.pop(), near=near))
        assert self._last is not None
        return self._last[1]

    def _is_last(self, place: int) -> bool:
        return self._last is not None and self._last[0] == place
