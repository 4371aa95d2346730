"""Overlay mode's layers: found by a job whenever the document asks for others, kept beside it."""

import numpy as np

from app.live.answer import Answer, explain
from app.model.jobs import Jobs, Task, Ticket
from app.model.session import Shown
from core.arrays import Ints, Points
from core.document.document import Document
from core.document.overlay import find_layers, get_found, get_layers
from core.document.overlay_layers import OverlayLayers
from core.document.overlay_settings import Search
from core.document.parts import picture_of
from core.grid import Grid
from core.imaging.images import Image
from core.mesh import Mesh
from core.overlay.detection.stages import Stage
from core.rasters.raster import Raster

FLAT_CELLS = 16
"""Cells along the longer side of a picture that nothing bends: more take time, larger ones round places more."""


class LiveOverlay:
    """Keeps the layers to the document it is shown; everything but the job on the UI thread."""

    def __init__(self, jobs: Jobs) -> None:
        self.fault: str | None = None
        """Why the present document has no layers."""
        self.ticket: Ticket | None = None
        """The job for the present document, whatever became of it; None before it was begun."""
        self.stage_lattice: tuple[Ints, Points] | None = None
        """Coordinates (n, 2) and positions (n, 2) of the lattice that the job under way has found so far."""
        self._jobs = jobs
        self._other: Ticket | None = None
        """A job that looks for another find on the photo, and makes that the document's."""
        self._image: Image | None = None
        self._search: Search | None = None
        self._covered: Raster | None = None
        self._layers: OverlayLayers | None = None
        self._is_final = False
        self._flat: Answer | None = None
        self._part: tuple[OverlayLayers, Shown, Image] | None = None
        """The picture that was made last."""

    @property
    def layers(self) -> OverlayLayers | None:
        """What is shown: the present document's layers, or while those are being found, the ones before, or rough."""
        return self._layers

    @property
    def is_final(self) -> bool:
        """Whether the layers are the present document's."""
        return self._is_final

    @property
    def under_way(self) -> Ticket | None:
        """The job that looks for the pattern now, if one does."""
        return next((job for job in (self.ticket, self._other) if job is not None and job.is_under_way), None)

    @property
    def is_running(self) -> bool:
        """Whether the pattern is being looked for."""
        return self.under_way is not None

    def watch(self, other: Ticket) -> None:
        """Show how far a job is that looks for another find on the photo, until the document asks for one itself."""
        self._other = other

    def answer(self, document: Document) -> Answer:
        """Return the editor's map, which leaves the picture as it is."""
        if self._flat is None or self._flat.document.image is not document.image:
            grid = Grid(*document.size_px, cell_px=max(document.size_px) / FLAT_CELLS)
            self._flat = Answer(document, Mesh(grid, grid.nodes), None, settled=True)
        return self._flat

    def update(self, document: Document, *, held: bool) -> None:
        """Bring the layers up to date with `document`, once per frame.

        The job that this needs begins when nothing is `held`, neither a gesture nor a slider.
        """
        if document.image is not self._image or document.cloth.search is not self._search:
            self._follow(document)
        elif document.cloth.covered is not self._covered:
            self._follow_cover(document)
        is_open = self._search is not None and not self._is_final and self.fault is None and self.ticket is None
        if is_open and not held:
            self._start(document)
        self._take_preview()

    def _follow(self, document: Document) -> None:
        """Forget what belongs to other inputs."""
        self.cancel()
        self._other = None
        image, search = document.image, document.cloth.search
        if image is not self._image or search is None:
            self._layers = None
        self._image, self._search, self._covered = image, search, document.cloth.covered
        self._begin_anew(document)
        self._layers = self._layers or get_found(document)

    def _follow_cover(self, document: Document) -> None:
        """Take what is covered by hand now; while the pattern is looked for, that goes on."""
        self._covered = document.cloth.covered
        if get_found(document) is not None:
            self._begin_anew(document)

    def _begin_anew(self, document: Document) -> None:
        """Forget the job under way, and take the layers if they are known."""
        if self.ticket is not None:
            self.ticket.cancel()
        self.fault = self.ticket = self.stage_lattice = None
        layers = get_layers(document)
        self._is_final = layers is not None
        self._layers = layers or self._layers

    def part(self, document: Document, shown: Shown) -> Image | None:
        """Return the picture of a part of what was found; None for what is no part, and while nothing is found."""
        if self._layers is None or shown == "result" or shown == "photo":
            return None
        if self._part is None or self._part[:2] != (self._layers, shown):
            self._part = self._layers, shown, picture_of(self._layers, document.image, shown)
        return self._part[2]

    @property
    def is_stopped(self) -> bool:
        """Whether the present document's layers were looked for, are not there, and nothing is looking for them."""
        was_sought = self._search is not None and self.ticket is not None
        return was_sought and not self._is_final and not self.is_running

    def go_on(self) -> None:
        """Begin the job anew that was cancelled or failed."""
        if self.is_stopped:
            self.ticket = self.fault = None

    def cancel(self) -> None:
        """Stop what is under way."""
        for job in (self.ticket, self._other):
            if job is not None:
                job.cancel()

    def _start(self, document: Document) -> None:
        def is_present() -> bool:
            return document.image is self._image and document.cloth.search is self._search

        def deliver(layers: OverlayLayers) -> None:
            if is_present():
                self._layers, self._is_final = layers, document.cloth.covered is self._covered
                if not self._is_final:
                    self.ticket = None

        def fail(fault: Exception) -> None:
            if is_present():
                self._take_fault(fault)

        name = "Find pattern" if get_found(document) is None else "Cover"
        self.ticket = self._jobs.start(Task(name, lambda: find_layers(document), deliver, fail))

    def _take_preview(self) -> None:
        """Take the newest lattice that the job has to show, or the layers as they lie, with the light of before."""
        if self._other is not None and not self._other.is_under_way:
            self._other = self.stage_lattice = None
        stage = self.under_way.progress.preview if self.under_way is not None else None
        if isinstance(stage, OverlayLayers) and self.under_way is self.ticket:
            # On these nothing is laid yet of what is covered by hand.
            self._layers = stage if self._covered is None or self._covered.is_empty else self._layers
        elif isinstance(stage, Stage) and stage.lattice is not None and stage.shape is not None:
            assert self._image is not None
            scale = -(-self._image.height_px // stage.shape[0])
            points = scale * stage.lattice.frames.points + (scale - 1) / 2
            self.stage_lattice = stage.lattice.keys, np.asarray(points, np.float64)

    def _take_fault(self, fault: Exception) -> None:
        self.fault = explain(fault, "finding the pattern failed")
        self._layers = self.stage_lattice = None
