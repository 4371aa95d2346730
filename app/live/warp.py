"""The map on the screen: follows the document by one solve a frame, and settles when the artist rests.

While something moves, the answer is the linear one, which may fold. A short while after the last change the final
answer is worked out in the background, as an export does it, and takes its place; until it is there, the first one
without folds does. If something moves meanwhile both are dropped.
"""

import time
from collections.abc import Callable
from dataclasses import replace

from app.live.answer import Answer, answer_without_handles, explain
from app.live.gpu_frames import GpuFrames, MakeSolver
from app.model.jobs import Jobs, Task
from core import tracing
from core.arrays import Points
from core.document.document import Document
from core.document.map import grid_of, options_of
from core.document.map_solver import MapSolver
from core.document.straight_lines import PictureLines, asked_lines
from core.mapping.result import Warped
from core.mesh import Mesh
from core.progress import Job, Progress, stepwise

INLINE_NODES = 60_000
"""Up to so many nodes a solve fits into a frame; larger grids are solved beside it."""
REST_S = 0.15
"""How long nothing may change, once there is an answer, before the final one is begun."""


class LiveWarp:
    """Keeps `answer` to the document it is shown; everything runs on the UI thread but the jobs."""

    def __init__(
        self,
        jobs: Jobs,
        *,
        clock: Callable[[], float] = time.monotonic,
        gpu: Callable[[], MakeSolver | None] = lambda: None,
    ) -> None:
        self.answer: Answer | None = None
        self.fault: str | None = None
        """Why the present document has no map of its own; the last one stays on the screen."""
        self._jobs = jobs
        self._clock = clock
        self._seen: Document | None = None
        self._rests_since = 0.0
        self._is_behind = False
        """Whether the document has changed since the solve that was begun last."""
        self._unfolded: tuple[Document, Points] | None = None
        """An answer without folds that the present settling has come by, and its document."""
        lines = PictureLines()
        self._solver = MapSolver(lines=lines)
        """This thread's, for grids that fit into a frame."""
        self._side_solver = MapSolver(lines=lines)
        """The live thread's, for final answers and for larger grids: what one of them has built, the next one finds."""
        self._gpu_frames = GpuFrames(gpu, lines)
        """The live thread's too, for what moves on larger grids, where a GPU does that."""
        self._settled: tuple[Document, Warped] | None = None
        """The last final answer."""

    @property
    def is_settled(self) -> bool:
        """Whether the answer is the final one of the present document, or there is none."""
        return self.fault is not None or (
            self.answer is not None and self.answer.settled and self.answer.document is self._seen
        )

    @property
    def _is_rough(self) -> bool:
        """Whether another live answer to the same document is nearer to the final one: it glides there."""
        answer = self.answer
        return (
            answer is not None
            and answer.document is self._seen
            and answer.result is not None
            and answer.result.is_rough
        )

    @property
    def wait_s(self) -> float | None:
        """Seconds until `update` has something to do without an event; None when that needs an event."""
        if self._seen is None or self.is_settled or self._jobs.holds("settle") or self._jobs.holds("solve"):
            return None
        return 0.0 if self._is_rough else max(0.0, self._rests_since + REST_S - self._clock())

    @property
    def _has_rested(self) -> bool:
        """Whether nothing has changed for so long that the final answer is begun."""
        if self._jobs.holds("settle") or self._jobs.holds("solve"):
            return False
        return self._clock() >= self._rests_since + REST_S

    def update(self, document: Document, *, is_seen: bool = True, beside: bool = False) -> None:
        """Bring the answer up to date with `document`; once per frame.

        One that is not seen is not answered before it is, or everything rests. What is answered `beside` the window
        keeps no frame waiting, and comes some frames later.
        """
        if self._seen is None or not _maps_alike(document, self._seen):
            self._jobs.drop("settle")
            self._seen, self.fault, self._is_behind = document, None, True
            self._rests_since = self._clock()
        elif document is not self._seen:
            self._rename(document)
        if self._is_behind and (is_seen or self.answer is None):
            self._is_behind = False
            self._solve(document, beside=beside)
            self._rests_since = self._clock()
        elif not self.is_settled and self._has_rested:
            # Before another rough answer, which may glide on for ever and keep the live thread.
            self._unfolded = None
            task = Task("Settle", lambda: self._settling(document), self._take_settled, self._take_fault, quiet=True)
            self._jobs.submit("settle", task)
        elif self._is_rough and not self._jobs.holds("settle"):
            self._solve(document, beside=beside)
        self._show_unfolded()

    def look_ahead(self) -> None:
        """Begin beside what the next frame of a drag needs: once this one is drawn, since it would take longer else."""
        self._solver.look_ahead()

    def _settling(self, document: Document) -> Job[Warped]:
        """Work out the final answer, and put the first one without folds where `update` finds it."""

        def keep(step: Progress) -> Progress:
            if step.preview is not None:
                self._unfolded = document, step.preview
            return step

        return stepwise(self._side_solver.settle(document), keep)

    def _show_unfolded(self) -> None:
        """Show the newest answer without folds on the way to the final one."""
        found, self._unfolded = self._unfolded, None
        answer = self.answer
        if found is None or answer is None or answer.result is None or answer.settled:
            return
        document, warped = found
        # A slider that is held, or let go, makes documents anew that have the same map.
        if answer.document is self._seen and _maps_alike(document, answer.document):
            with tracing.span("unfolded"):
                result = replace(answer.result, warped=warped, folds=None)
                self.answer = replace(answer, mesh=Mesh(answer.grid, warped), result=result)

    def settled(self, document: Document) -> Warped | None:
        """Return the final answer to a document, where it is known."""
        found = self._settled
        return found[1] if found is not None and _maps_alike(document, found[0]) else None

    def current(self, document: Document) -> Answer:
        """Return the answer to `document`, as far as one is there."""
        if self.answer is None:
            self.update(document)
        return self.answer if self.answer is not None else answer_without_handles(document)

    def _solve(self, document: Document, *, beside: bool) -> None:
        """Answer now if that fits into a frame; else show the last answer until the live thread has one."""
        try:
            if self.answer is None or self.answer.document.image is not document.image:
                self.answer = answer_without_handles(document)
            if self._jobs.holds("solve"):
                return
            if not beside and _fits_into_frame(document) and not self._solver.is_heavy(document):
                self._show(document, *self._timed(self._solver.frame, document))
            else:
                self._solve_beside(document)
        except Exception as fault:  # noqa: BLE001  whatever it is, the last map stays and the artist goes on
            self._take_fault(fault)

    def _solve_beside(self, document: Document) -> None:
        """Solve in the live slot; of what changes meanwhile only the newest is answered next, by `update`."""

        def steps() -> Job[tuple[Warped, float]]:
            yield Progress(0.0, "solving")
            return self._timed(self._frame_beside, document)

        def deliver(result: tuple[Warped, float]) -> None:
            if _fits_into_frame(document):  # the next frames are answered on this thread, with what has been built
                self._solver, self._side_solver = self._side_solver, self._solver
            if self._seen is not None and document.image is self._seen.image:
                self._show(document, *result)
            go_on()

        def fail(fault: Exception) -> None:
            if document is self._seen:
                self._take_fault(fault)
            go_on()

        def go_on() -> None:
            self._is_behind = self._seen is not None and not _maps_alike(document, self._seen)

        self._jobs.submit("solve", Task("Solve", steps, deliver, fail))

    def _frame_beside(self, document: Document) -> Warped:
        """Return the linear answer, worked out on the live thread."""
        found = None
        if not _fits_into_frame(document):
            settled = self._settled
            if settled is not None and not _maps_alike(_bare(document), _bare(settled[0])):
                settled = None
            found = self._gpu_frames.frame(document, settled)
        if found is None:
            found = self._side_solver.frame(document)
            self._side_solver.look_ahead()
        _ = found.folded  # worked out here: the window asks for it in every frame
        return found

    def _timed(self, solve: Callable[[Document], Warped], document: Document) -> tuple[Warped, float]:
        """Return the map of `document` and how many milliseconds it took."""
        started = self._clock()
        result = solve(document)
        return result, 1e3 * (self._clock() - started)

    def _show(self, document: Document, result: Warped, solve_ms: float = 0.0, *, final: bool = False) -> None:
        with tracing.span("answer", settled=final):
            grid = grid_of(document)
            if self.answer is not None and self.answer.grid == grid:
                grid = self.answer.grid  # its nodes are worked out
            mesh = Mesh(grid, result.warped)
            self.answer = Answer(document, mesh, result, settled=final, solve_ms=solve_ms)

    def _take_settled(self, result: Warped) -> None:
        if self._seen is None:
            return
        self._show(self._seen, result, final=True)
        self._settled = self._seen, result
        was_behind, self._is_behind = self._is_behind, False
        if not _fits_into_frame(self._seen):
            return  # the live thread answers the next frames, too
        # What the final answer has built need not be built again.
        if was_behind or self._solver.is_heavy(self._seen):
            self._solver, self._side_solver = self._side_solver, self._solver
        else:
            self._solver.learn(self._seen, result)

    def _take_fault(self, fault: Exception) -> None:
        self.fault = explain(fault, "the map failed")

    def _rename(self, document: Document) -> None:
        """Keep the answer for a document that differs only in what the map does not depend on."""
        if self.answer is not None and self.answer.document is self._seen:
            self.answer = Answer(
                document,
                self.answer.mesh,
                self.answer.result,
                settled=self.answer.settled,
                solve_ms=self.answer.solve_ms,
            )
        self._seen = document


def _fits_into_frame(document: Document) -> bool:
    """Return whether a solve on the document's grid fits into a frame."""
    return grid_of(document).size <= INLINE_NODES


def _bare(document: Document) -> Document:
    """Return a document without handles."""
    return replace(document, pins=(), curves=())


def _maps_alike(a: Document, b: Document) -> bool:
    """Return whether two documents have the same map because what it depends on is the same."""
    return (
        a.image is b.image
        and a.mask is b.mask
        and a.numbers is b.numbers
        and a.given_up == b.given_up
        and a.warp == b.warp
        and options_of(a) == options_of(b)
        and asked_lines(a) == asked_lines(b)
        and a.outline is b.outline
        and a.warp_map is b.warp_map
        and a.surface is b.surface
        and a.pins == b.pins
        and a.curves == b.curves
    )
