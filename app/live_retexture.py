"""Retexture mode's picture: the Laplacian deformation by one solve a frame, then the regrown texture from a job.

While targets are dragged, the deformation is anchored at the source curves, whose factor stays. When the artist lets
go, the retexture runs as a job over the document of that moment: its first stage brings the final deformation, the
next ones pictures, coarse and then final. Results of documents that were left by undo are kept for a while.
"""

import logging
import time
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from app.jobs import Jobs, Task, Ticket
from app.live import Answer
from app.session import Look
from core import tracing
from core.arrays import Points, WeftError
from core.document import Document
from core.document_map import grid_of
from core.document_retexture import Regrown, feature_curves, in_pixels, moves, regrown
from core.grid import Grid
from core.images import Image
from core.mesh import Mesh
from core.retexture.preview import LiveDeformation, pulled

log = logging.getLogger("weft")
KEPT_PIXELS = 30_000_000
"""Results are kept while their pixels are no more, the newest in any case."""

Inputs: TypeAlias = tuple[object, ...]


@dataclass(frozen=True, eq=False)
class Shown:
    """What the canvas draws: `image` with its places `rest` (R, C, 2) at `warped` (R, C, 2)."""

    image: Image
    rest: Points
    warped: Points


@dataclass(frozen=True, eq=False)
class PulledMesh(Mesh):
    """A mesh that knows the way back: the picture's place `source` (R, C, 2) at every node of the canvas."""

    source: Points

    def image_from_canvas(self, points: Points) -> Points:
        """Return the picture's positions of canvas positions (n, 2)."""
        nodes, weights = self.grid.weights_at(np.asarray(points, np.float64).reshape(-1, 2))
        found: Points = np.einsum("nk,nkc->nc", weights, self.source.reshape(-1, 2)[nodes])
        return found


class LiveRetexture:
    """Keeps deformation and regrown picture to the document it is shown; everything but the job on the UI thread."""

    def __init__(self, jobs: Jobs) -> None:
        self.fault: str | None = None
        """Why the present document has no result of its own."""
        self.solve_ms = 0.0
        self.ticket: Ticket | None = None
        """The job for the present document, whatever became of it; None before it was begun."""
        self._jobs = jobs
        self._seen: Document | None = None
        self._grid = Grid(1, 1)
        self._live: LiveDeformation | None = None
        self._anchors: Inputs = ()
        """What the live factor belongs to."""
        self._lacks_factor = False
        """Whether a source was moved since, by what is still in progress."""
        self._warped: Points | None = None
        """Where the live deformation has the nodes; None where it has no answer."""
        self._stage: Regrown | None = None
        self._source: Points | None = None
        """The places that the final deformation shows at the nodes."""
        self._final: list[tuple[Inputs, Regrown]] = []
        self._is_final = False

    @property
    def stage(self) -> Regrown | None:
        """What the job has brought for the present document so far."""
        return self._stage

    @property
    def is_final(self) -> bool:
        """Whether the final result of the present document is there."""
        return self._is_final

    @property
    def is_running(self) -> bool:
        """Whether the present document's job is under way."""
        return self.ticket is not None and self.ticket in self._jobs.long_jobs and not self.ticket.cancelled

    @property
    def flat(self) -> Mesh:
        """The picture as it is."""
        return Mesh(self._grid, self._grid.nodes)

    @property
    def mesh(self) -> Mesh:
        """Where the deformation has the picture."""
        warped = self._grid.nodes if self._warped is None else self._warped
        return Mesh(self._grid, warped) if self._source is None else PulledMesh(self._grid, warped, self._source)

    def answer(self, document: Document) -> Answer:
        """Return the deformation as the editor's map."""
        if self._seen is None:
            self._follow(document, held=False)
        return Answer(document, self.mesh, None, settled=self._source is not None, solve_ms=self.solve_ms)

    def shown(self, document: Document, look: Look) -> Shown:
        """Return what the canvas draws; where the retextured picture is not there yet, the deformation."""
        nodes = self._grid.nodes
        if look == "original" or not moves(document):
            return Shown(document.image, nodes, nodes)
        if look == "retextured" and self._stage is not None and self._stage.image is not None:
            return Shown(self._stage.image, nodes, nodes)
        if self._source is not None:
            return Shown(document.image, self._source, nodes)
        return Shown(document.image, nodes, nodes if self._warped is None else self._warped)

    def update(self, document: Document, *, held: bool, starts: bool) -> bool:
        """Bring everything up to date with `document`, once per frame; return whether targets have moved since.

        `held` is whether a gesture or a slider is in progress, `starts` whether the job begins by itself.
        """
        changed = self._seen is None or _inputs(document) != _inputs(self._seen)
        if changed or (self._lacks_factor and not held):
            self._follow(document, held=held)
        self._seen = document
        self._take_stage()
        if starts and not held and self.ticket is None and not self._is_final:
            self.start(document)
        return changed and self._warped is not None

    def start(self, document: Document) -> None:
        """Begin the job for `document` anew; nothing where no curve moves."""
        self.cancel()
        if not moves(document):
            return
        inputs = _inputs(document)

        def deliver(result: Regrown) -> None:
            self._keep(inputs, result)
            if self._seen is not None and inputs == _inputs(self._seen):
                self._take(result, final=True)

        def fail(fault: Exception) -> None:
            if self._seen is not None and inputs == _inputs(self._seen):
                self._take_fault(fault)

        self.ticket = self._jobs.start(Task("Retexture", lambda: regrown(document), deliver, fail))

    def cancel(self) -> None:
        """Stop the job under way; what it has brought stays."""
        if self.ticket is not None:
            self.ticket.cancel()

    def _follow(self, document: Document, *, held: bool) -> None:
        """Forget what belongs to other inputs and solve for these."""
        self.cancel()
        self.ticket = self._stage = self._source = self.fault = None
        self._is_final = False
        grid = grid_of(document)
        # The renderer knows the nodes by their identity.
        self._grid = self._grid if grid == self._grid else grid
        kept = next((result for inputs, result in self._final if inputs == _inputs(document)), None)
        try:
            self._solve(document, held=held)
            if kept is not None:
                self._take(kept, final=True)
        except Exception as fault:  # noqa: BLE001  whatever it is, the picture stays and the artist goes on
            self._take_fault(fault)

    def _solve(self, document: Document, *, held: bool) -> None:
        """Solve for the targets; a new factor only between gestures: who moves a source looks at the original."""
        self._warped = None
        anchors, started = _anchors(document), time.perf_counter()
        if anchors != self._anchors:
            self._live, self._anchors, self._lacks_factor = None, (), held
            if held or all(pair.passive for pair in document.feature_curves):
                return
            width, height = document.size_px
            reach_px = in_pixels(document, document.retexture.move_within)
            curves = feature_curves(document)
            self._live = LiveDeformation((height, width), curves, self._grid.nodes, reach_px=reach_px)
            self._anchors = anchors
        if self._live is None or not moves(document):
            return
        with tracing.span("answer", settled=False):
            self._warped = self._live.solve(feature_curves(document))
        self.solve_ms = 1e3 * (time.perf_counter() - started)

    def _take_stage(self) -> None:
        """Show the newest stage of the job."""
        stage = None if self.ticket is None or self.ticket.cancelled else self.ticket.progress.preview
        if isinstance(stage, Regrown) and stage is not self._stage and not self._is_final:
            self._take(stage, final=False)

    def _take(self, stage: Regrown, *, final: bool) -> None:
        if self._source is None:
            self._source = pulled(stage.found.grid, stage.found.field, self._grid.nodes)
        self._stage, self._is_final = stage, final

    def _take_fault(self, fault: Exception) -> None:
        if not isinstance(fault, WeftError):
            log.error("retexturing failed", exc_info=fault)
        self.fault = str(fault) or type(fault).__name__

    def _keep(self, inputs: Inputs, result: Regrown) -> None:
        """Keep a final result, and of the older ones what there is room for."""
        self._final = [(inputs, result), *(entry for entry in self._final if entry[0] != inputs)]
        room = KEPT_PIXELS
        for number, (_, kept) in enumerate(self._final):
            room -= kept.found.label.size
            if room < 0 and number:
                del self._final[number:]
                return


def _inputs(document: Document) -> Inputs:
    """Return all that the result depends on; two are equal if they are the same objects or say the same."""
    return (
        document.image,
        document.feature_curves,
        document.retexture,
        document.matte,
        document.source_mask,
        document.warp.cell_px,
    )


def _anchors(document: Document) -> Inputs:
    """Return what the live factor depends on."""
    curves = tuple((pair.source.tobytes(), pair.closed) for pair in document.feature_curves if not pair.passive)
    return (document.image, document.warp.cell_px, document.retexture.move_within, curves)
