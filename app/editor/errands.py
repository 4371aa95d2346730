"""What the editor gives to others to do, and what it tells the artist of it: long jobs, messages and faults."""

import logging
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, TypeVar

from app.model.jobs import Jobs, Task, Ticket
from core.arrays import WeftError
from core.document.document import Document
from core.files.text import begin_sentence, legible
from core.progress import Job

log = logging.getLogger("weft")
T = TypeVar("T")


@dataclass(frozen=True)
class Notice:
    """A message for the artist."""

    text: str
    level: Literal["info", "error"] = "info"
    holds: Callable[[], bool] | None = field(default=None, compare=False)
    """Whether what it says still holds; None for what does not pass."""

    @property
    def still_holds(self) -> bool:
        """Whether it is still to be read."""
        return self.holds is None or self.holds()


class Errands(ABC):
    """Runs jobs beside a document that is edited, and keeps messages for the artist."""

    def __init__(self, jobs: Jobs) -> None:
        self.jobs = jobs
        self.take_fault: Callable[[Exception], None] | None = None
        """Takes faults of the program itself in the place of a notice; the window puts it here."""
        self.notices: list[Notice] = []

    @property
    @abstractmethod
    def document(self) -> Document:
        """The present document."""

    @abstractmethod
    def edit(self, label: str, document: Document, *, joins: bool = False) -> None:
        """Make `document` the present one, as one undo entry."""

    def notify(
        self, text: str, level: Literal["info", "error"] = "info", *, holds: Callable[[], bool] | None = None
    ) -> None:
        """Leave a message for the artist, which goes once it no longer `holds`."""
        self.notices.append(Notice(begin_sentence(legible(text)), level, holds))

    def fail(self, fault: Exception, *, holds: Callable[[], bool] | None = None) -> None:
        """Tell the artist what went wrong; a fault of the program itself goes to `take_fault` and to the log."""
        if isinstance(fault, WeftError | OSError | MemoryError):
            self.notify("not enough memory" if isinstance(fault, MemoryError) else str(fault), "error", holds=holds)
            return
        log.error("a job failed", exc_info=fault)
        if self.take_fault is not None:
            self.take_fault(fault)
        else:
            self.notify(str(fault) or type(fault).__name__, "error")

    def start(
        self,
        name: str,
        steps: Callable[[], Job[T]],
        apply: Callable[[Document, T], Document | None],
        *,
        beside: bool = False,
        holds: Callable[[], bool] | None = None,
    ) -> Ticket:
        """Run a long job and make what `apply` returns one undo entry called `name`.

        `apply` gets the document of that moment, and returns None where the job's result no longer fits it. A job
        `beside` waits for none of the others. What is said of its fault goes once it no longer `holds`.
        """

        def deliver(result: T) -> None:
            document = apply(self.document, result)
            if document is not None:
                self.edit(name, document)

        fail = lambda fault: self.fail(fault, holds=holds)  # noqa: E731
        return self.jobs.start(Task(name, steps, deliver, fail, edits=True), beside=beside)

    def background(
        self,
        name: str,
        steps: Callable[[], Job[T]],
        deliver: Callable[[T], None],
        *,
        failed: Callable[[Exception], None] | None = None,
        writes: bool = False,
    ) -> Ticket:
        """Run a long job whose result is not an edit; it is handed over when no gesture is in progress.

        `failed` takes its fault in the place of the artist. `writes` says that it makes a file, which the window does
        not close upon unasked.
        """
        return self.jobs.start(Task(name, steps, deliver, failed or self.fail, edits=True, writes=writes))
