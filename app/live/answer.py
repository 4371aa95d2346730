"""A map on the screen: where the picture is, and what is known of it."""

import logging
from dataclasses import dataclass
from functools import cached_property

from core.arrays import Bools, Points, WeftError
from core.document.document import Document
from core.document.map import grid_of, preset_of
from core.grid import Features, Grid
from core.mapping.result import PinReport, Warped
from core.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Answer:
    """A map and the document that it belongs to."""

    document: Document
    mesh: Mesh
    """Where the picture is; for finding places on it."""
    result: Warped | None
    """None for what is shown before the first solve."""
    settled: bool = False
    """Whether this is the final answer, the one that an export gives."""
    solve_ms: float = 0.0
    """What working it out took, handles included."""

    @property
    def grid(self) -> Grid:
        """The grid over the picture."""
        return self.mesh.grid

    @property
    def rest(self) -> Points:
        """Nodes (R, C, 2) in pixels of the picture."""
        return self.mesh.grid.nodes

    @property
    def warped(self) -> Points:
        """Where the nodes (R, C, 2) are, in pixels of the canvas."""
        return self.mesh.warped

    @property
    def plain(self) -> Points:
        """Where W alone takes the nodes (R, C, 2)."""
        return self.warped if self.result is None else self.result.plain

    @property
    def features(self) -> Features | None:
        """The features that keep their shape."""
        return None if self.result is None else self.result.marked

    @property
    def folded(self) -> Bools | None:
        """Which quads (R - 1, C - 1) are folded."""
        return None if self.result is None else self.result.folded

    @cached_property
    def folds(self) -> int:
        """How many quads are folded."""
        return 0 if self.folded is None else int(self.folded.sum())

    @property
    def outline_moved_px(self) -> float:
        """How far the outline gave way so that nothing folds."""
        return 0.0 if self.result is None else self.result.outline_moved_px

    @property
    def pins(self) -> list[PinReport]:
        """What became of the document's pins, in their order; nothing while they are newer than the answer."""
        return [] if self.result is None else self.result.pin_reports

    @cached_property
    def base_mesh(self) -> Mesh:
        """Where the preset has the picture, without handles."""
        return Mesh(self.grid, preset_of(self.document)(self.rest))


def answer_without_handles(document: Document) -> Answer:
    """Return the answer by preset alone, or by nothing where even that fails."""
    try:
        grid = grid_of(document)
        return Answer(document, Mesh(grid, preset_of(document)(grid.nodes)), None)
    except WeftError:
        grid = Grid(*document.size_px)
        return Answer(document, Mesh(grid, grid.nodes), None)


def explain(fault: Exception, what: str) -> str:
    """Return why something has failed; `what` that was is told to the log, where the program is at fault."""
    if not isinstance(fault, WeftError):
        logging.getLogger("weft").error(what, exc_info=fault)
    return str(fault) or type(fault).__name__
