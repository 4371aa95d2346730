"""From a document to its map: what the window shows at rest, and what is saved, reopened and exported.

Two objects keep what the next answer can use; nothing of a map is kept by a module:

    document  --[MapInputs]-->  grid, features, options, W  --[Warper]-->  map

`MapInputs` gives the same objects while what they are made of is the same, so that `Warper` knows by them what still
holds. `settle_map` is the one way to the final answer. It begins from nothing but the document, so that the same
document gives the same bits, on screen and in a file.
"""

from collections.abc import Callable

from core.arrays import Points
from core.document.document import Document, pixels_from_places
from core.document.map import bend_of, grid_of, handles_of, options_of, start_of
from core.document.smooth_warp import SmoothWarp
from core.document.stiff_pins import StiffNodes
from core.document.straight_lines import PictureLines, asked_lines
from core.grid import DEFAULT_NODES_AT_MOST, Features, Grid
from core.linalg.grid_solver import GridSolver
from core.linalg.multifrontal import GridFactor
from core.mapping.features.straight_lines import Lines
from core.mapping.options import MappingOptions
from core.mapping.result import Warped
from core.mapping.warper import Warper
from core.progress import Job
from core.selection.nodes import MarkedNodes
from core.warps.outline import follow_outline
from core.warps.warp import Warp, in_parts


def settle_map(document: Document) -> Job[Warped]:
    """Return the map of `document`, without folds where W has none."""
    return (yield from MapSolver().settle(document))


class MapInputs:
    """What a document asks of the mapping; each part is the same object as before while what it is made of is.

    For one grid, and one thread at a time.
    """

    def __init__(self, grid: Grid, lines: PictureLines) -> None:
        self.grid, self._picture_lines = grid, lines
        self._marked, self._stiff = MarkedNodes(grid), StiffNodes(grid)
        self._lines: tuple[object, Lines | None] | None = None
        self._start: tuple[object, Points] | None = None
        self._plain: tuple[object, Points, bool] | None = None
        self._smooth: SmoothWarp | None = None

    def features(self, document: Document) -> Features:
        """Return where the nodes are in features that keep their shape, and in what stiff pins hold."""
        painted = self._marked.features(document.mask, document.numbers, document.given_up)
        return self._stiff.add(painted, document)

    def options(self, document: Document) -> MappingOptions:
        """Return what the document says about its features and straight lines."""
        key = document.image, *asked_lines(document)
        if self._lines is None or self._lines[0] != key:
            self._lines = key, self._picture_lines.choose(document)
        return options_of(document, self._lines[1])

    def is_laid(self, document: Document) -> bool:
        """Return whether it is known where the document's surface, or the warp that was opened, takes the nodes."""
        return self._start is not None and self._start[0] == _laid_by(document)

    def plain(self, document: Document, *, seen: bool = False) -> Points:
        """Return where preset and outline take the nodes (R, C, 2); the same while pins and curves are dragged.

        What is only `seen` may be off by what nobody sees.
        """
        if self._start is None or not self.is_laid(document):
            start = start_of(document)
            self._start = _laid_by(document), self.grid.nodes if start is None else start(self.grid.nodes)
            self._plain = None
        key = document.warp, document.canvas_px, document.outline
        if self._plain is None or self._plain[0] != key or not (seen or self._plain[2]):
            is_plain = document.warp.preset is None or self._start[1] is not self.grid.nodes
            is_exact = not seen or is_plain or self.grid.size <= DEFAULT_NODES_AT_MOST
            plain = in_parts(bend_of(document), self._start[1]) if is_exact else self._seen(bend_of(document))
            if document.outline is not None:
                plain = follow_outline(plain, pixels_from_places(document.canvas_px, document.outline.ring))
            plain.flags.writeable = False  # it is new: nobody else has it to write to
            self._plain = key, plain, is_exact
        return self._plain[1]

    def _seen(self, bend: Warp) -> Points:
        if self._smooth is None:
            self._smooth = SmoothWarp(self.grid)
        return self._smooth.evaluate(bend)


def _laid_by(document: Document) -> tuple[object, ...]:
    return document.warp_map, document.surface, document.size_px


class MapSolver:
    """Answers one document after another. For one thread at a time; solvers may share the `lines` of a picture.

    Raises `InputError` for a document that has no map. `analyse` makes what solves the system of a grid of that shape.
    """

    def __init__(
        self,
        *,
        analyse: Callable[[tuple[int, int]], GridSolver] = GridFactor,
        lines: PictureLines | None = None,
    ) -> None:
        self._analyse, self._lines = analyse, PictureLines() if lines is None else lines
        self._kept: tuple[MapInputs, Warper] | None = None

    def is_heavy(self, document: Document) -> bool:
        """Return whether the next answer needs more than a frame's time: another grid, surface or straight lines."""
        if self._kept is None or self._kept[0].grid != grid_of(document) or not self._lines.are_known(document):
            return True
        inputs, warper = self._kept
        if not inputs.is_laid(document):
            return True
        return not warper.is_ready(inputs.features(document), inputs.options(document))

    def frame(self, document: Document) -> Warped:
        """Return the linear answer, which may fold: a solve, and a factorisation where structure changed."""
        inputs, warper = self._prepare(document)
        return warper.frame(inputs.plain(document, seen=True), handles_of(document))

    def look_ahead(self) -> None:
        """Begin beside what the next frame of a drag needs of this one, once nothing more is done for this one."""
        if self._kept is not None:
            self._kept[1].look_ahead()

    def settle(self, document: Document, *, near: Warped | None = None) -> Job[Warped]:
        """Return the answer without folds where W has none; the same bits, whatever was answered before.

        Of several answers that are about as good, it is the one next to that of a document that is `near`.
        """
        inputs, warper = self._prepare(document)
        reference = None if near is None else near.reference
        return (yield from warper.settle(inputs.plain(document), handles_of(document), near=reference))

    def folds(self, document: Document) -> bool:
        """Return whether the linear answer folds where W does not, so that there may be several answers at rest."""
        inputs, warper = self._prepare(document)
        return warper.folds(inputs.plain(document))

    def learn(self, document: Document, settled: Warped) -> None:
        """Take the picture without handles from an answer at rest to the same document."""
        inputs, warper = self._prepare(document)
        if settled.reference is not None:
            warper.learn(inputs.plain(document, seen=True), settled.reference)

    def _prepare(self, document: Document) -> tuple[MapInputs, Warper]:
        """Return what the document asks for and, prepared for it, what answers."""
        grid = grid_of(document)
        if self._kept is None or self._kept[0].grid != grid:
            self._kept = MapInputs(grid, self._lines), Warper(grid, analyse=self._analyse)
        inputs, warper = self._kept
        warper.use(inputs.features(document), inputs.options(document))
        return inputs, warper
