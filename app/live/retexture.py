"""Retexture mode's picture: the Laplacian deformation by one solve a frame, then the regrown texture from a job.

While curves are dragged, the deformation is solved for on the grid that is drawn. When the artist lets go, the
retexture runs as a job over the document of that moment: its first stage brings the final deformation, the next ones
pictures, coarse and then final. Results of documents that were left by undo are kept for a while.
"""

import time
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from app.live.answer import Answer, explain
from app.model.jobs import Jobs, Task, Ticket
from app.model.session import Look
from core import tracing
from core.arrays import CurveError, Points
from core.document.document import Document
from core.document.map import grid_of
from core.document.retexture import Regrown, feature_curves, in_pixels, moves, regrow
from core.grid import Grid
from core.imaging.images import Image
from core.mesh import Mesh
from core.retexture.deformation.preview import LiveDeformation, pull

KEPT_PIXELS = 30_000_000
"""Results are kept while their pixels are no more, the newest in any case."""

Inputs: TypeAlias = tuple[object, ...]


@dataclass(frozen=True, eq=False)
class ShownPicture:
    """What the canvas draws: `image` with its places `rest` (R, C, 2) at `warped` (R, C, 2)."""

    image: Image
    rest: Points
    warped: Points
    source: Points | None = None
    """Where something in `image` was regrown: the places (R, C, 2) of the document's picture that it was made from."""


@dataclass(frozen=True, eq=False)
class PulledMesh(Mesh):
    """A mesh that rests on the canvas: its nodes show the places `source` (R, C, 2) of the picture."""

    source: Points

    def image_from_canvas(self, points: Points) -> Points:
        """Return the picture's positions of canvas positions (n, 2)."""
        return self._back.canvas_from_image(np.reshape(points, (-1, 2)))

    def canvas_from_image(self, points: Points) -> Points:
        """Return where positions of the picture (n, 2) are shown; NaN for those that are shown nowhere."""
        return self._back.image_from_canvas(points)

    @cached_property
    def _back(self) -> Mesh:
        return Mesh(self.grid, self.source)


class LiveRetexture:
    """Keeps deformation and regrown picture to the document it is shown; everything but the job on the UI thread."""

    def __init__(self, jobs: Jobs) -> None:
        self.fault: str | None = None
        """Why the present document has no result of its own."""
        self.faulty_curve: int | None = None
        """The number of the curve that this is due to, if it is one."""
        self.solve_ms = 0.0
        self.ticket: Ticket | None = None
        """The job for the present document, whatever became of it; None before it was begun."""
        self._jobs = jobs
        self._seen: Document | None = None
        self._grid = Grid(1, 1)
        self._live: LiveDeformation | None = None
        self._live_inputs: Inputs = ()
        """What the live deformation was made for."""
        self._source: Points | None = None
        """The places of the picture that the deformation shows at the nodes; None where no curve moves."""
        self._stage: Regrown | None = None
        self._final: list[tuple[Inputs, Regrown]] = []
        self._is_final = False
        self._outlived = False
        """Whether the result shown is that of a document with other masks, which stays till the next is there."""
        self.is_moving = False
        """Whether what is in progress has moved curves."""

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
        return self.flat if self._source is None else PulledMesh(self._grid, self._grid.nodes, self._source)

    def answer(self, document: Document) -> Answer:
        """Return the deformation as the editor's map."""
        if self._seen is None:
            self._follow(document)
        return Answer(document, self.mesh, None, settled=self._stage is not None, solve_ms=self.solve_ms)

    def choose_picture(self, document: Document, look: Look) -> ShownPicture:
        """Return what the canvas draws; where the retextured picture is not there yet, the deformation."""
        nodes = self._grid.nodes
        if look == "retextured" and self._stage is not None and self._stage.image is not None:
            return ShownPicture(self._stage.image, nodes, nodes, self._source)
        if look == "original" or self._source is None:
            return ShownPicture(document.image, nodes, nodes)
        return ShownPicture(document.image, self._source, nodes)

    def update(self, document: Document, *, held: bool, starts: bool) -> bool:
        """Bring everything up to date with `document`, once per frame; return whether targets have moved since.

        `held` is whether a gesture or a slider is in progress, `starts` whether the job begins by itself.
        """
        seen = self._seen
        is_other = seen is not None and seen.feature_curves is not document.feature_curves
        self.is_moving = held and (self.is_moving or is_other)
        if seen is None or _inputs(document) != _inputs(seen):
            self._follow(document)
        self._seen = document
        self._take_stage()
        if starts and not held and self.ticket is None and not self._is_final:
            self.start(document)
        return seen is not None and self._source is not None and _targets_moved(seen, document)

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

        self.ticket = self._jobs.start(Task("Retexture", lambda: regrow(document), deliver, fail))

    def cancel(self) -> None:
        """Stop the job under way; what it has brought stays."""
        if self.ticket is not None:
            self.ticket.cancel()

    def _follow(self, document: Document) -> None:
        """Forget what belongs to other inputs and solve for these; where masks alone differ, what is shown stays."""
        self.cancel()
        self.ticket = self.fault = self.faulty_curve = None
        self._is_final, self._outlived = False, self._stage is not None and _differ_by_masks(self._seen, document)
        if not self._outlived:
            self._stage = self._source = None
        grid = grid_of(document)
        # The renderer knows the nodes by their identity.
        self._grid = self._grid if grid == self._grid else grid
        kept = next((result for inputs, result in self._final if inputs == _inputs(document)), None)
        try:
            if kept is not None:
                self._take(kept, final=True)
            elif moves(document) and not self._outlived:
                self._solve(document)
        except Exception as fault:  # noqa: BLE001  whatever it is, the picture stays and the artist goes on
            self._take_fault(fault)

    def _solve(self, document: Document) -> None:
        """Solve for the curves as they are."""
        reach_px = in_pixels(document, document.retexture.move_within)
        inputs = (document.size_px, self._grid, reach_px)
        if self._live is None or inputs != self._live_inputs:
            width, height = document.size_px
            self._live = LiveDeformation((height, width), self._grid.nodes, reach_px=reach_px)
            self._live_inputs = inputs
        started = time.perf_counter()
        with tracing.span("answer", settled=False):
            self._source = self._live.solve(feature_curves(document))
        self.solve_ms = 1e3 * (time.perf_counter() - started)

    def _take_stage(self) -> None:
        """Show the newest stage of the job."""
        stage = None if self.ticket is None or self.ticket.cancelled else self.ticket.progress.preview
        if isinstance(stage, Regrown) and stage is not self._stage and not (self._is_final or self._outlived):
            self._take(stage, final=False)

    def _take(self, stage: Regrown, *, final: bool) -> None:
        if self._stage is None:
            self._source = pull(stage.found.grid, stage.found.field, self._grid.nodes)
        self._stage, self._is_final, self._outlived = stage, final, False

    def _take_fault(self, fault: Exception) -> None:
        self.fault = explain(fault, "retexturing failed")
        self.faulty_curve = fault.number - 1 if isinstance(fault, CurveError) else None

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
    return (*_inputs_but_masks(document), *document.retexture_masks.values())


def _inputs_but_masks(document: Document) -> Inputs:
    return document.image, document.feature_curves, document.retexture, document.warp.cell_px


def _differ_by_masks(before: Document | None, after: Document) -> bool:
    """Return whether nothing differs that matters for the result but where it may be."""
    return before is not None and _inputs_but_masks(before) == _inputs_but_masks(after)


def _targets_moved(before: Document, after: Document) -> bool:
    """Return whether the same curves go elsewhere than before; a source that takes its target along does not count."""
    pairs = zip(before.feature_curves, after.feature_curves, strict=False)
    return any(np.array_equal(a.source, b.source) and not np.array_equal(a.target, b.target) for a, b in pairs)
