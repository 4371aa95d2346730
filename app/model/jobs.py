"""Work off the UI thread: slots where the latest submission wins, and a queue of long jobs.

A job is a generator over an immutable snapshot (`core.progress`). It runs on a worker thread and never sees the
editor. Its result waits until the UI thread calls `drain`, which hands it over. Threads are behind `Executor`, so that
tests run jobs where and when they like.
"""

import contextlib
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from queue import SimpleQueue
from typing import Any, Generic, Protocol, TypeAlias, TypeVar

from core import tracing
from core.notices import hear_notices
from core.progress import Job, Progress

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Task(Generic[T]):
    """What is to be done and who gets the result."""

    name: str
    """As the artist reads it: "Export picture"."""
    steps: Callable[[], Job[T]]
    """Starts the generator; called on the worker thread."""
    deliver: Callable[[T], None]
    """Takes the result on the UI thread."""
    fail: Callable[[Exception], None]
    """Takes the exception on the UI thread."""
    edits: bool = False
    """Whether `deliver` changes the document, so that it must wait until no gesture is in progress."""
    writes: bool = False
    """Whether it makes a file that the artist has asked for."""
    quiet: bool = False
    """Whether nothing shows how far it is, so that only a step's preview is worth a frame."""


@dataclass(eq=False)
class Ticket:
    """A submitted task: how far it is, and the way to cancel it."""

    task: Task[Any]
    progress: Progress = field(default_factory=lambda: Progress(0.0))
    state: str = "waiting"
    """waiting, running, finished, failed or cancelled."""
    _cancelled: threading.Event = field(default_factory=threading.Event)

    @property
    def name(self) -> str:
        """The task's name."""
        return self.task.name

    @property
    def cancelled(self) -> bool:
        """Whether the task is to stop at its next yield; its result is dropped."""
        return self._cancelled.is_set()

    @property
    def is_under_way(self) -> bool:
        """Whether the task waits or runs, and its result is wanted."""
        return self.state in ("waiting", "running") and not self.cancelled

    def cancel(self) -> None:
        """Stop the task at its next yield and drop its result."""
        self._cancelled.set()


class Executor(Protocol):
    """Something that calls functions one after the other, now or later."""

    def submit(self, work: Callable[[], None]) -> None:
        """Call `work` when its turn comes."""

    def close(self) -> None:
        """Finish what was submitted and take no more."""


class ThreadExecutor:
    """One daemon thread with a queue."""

    def __init__(self, name: str) -> None:
        self._queue: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def submit(self, work: Callable[[], None]) -> None:
        """Call `work` on the thread."""
        self._queue.put(work)

    def close(self) -> None:
        """Wait for what was submitted and end the thread."""
        self._queue.put(None)
        self._thread.join()

    def _run(self) -> None:
        while (work := self._queue.get()) is not None:
            work()


class InlineExecutor:
    """Calls at once, on the caller's thread."""

    def submit(self, work: Callable[[], None]) -> None:
        """Call `work` now."""
        work()

    def close(self) -> None:
        """Do nothing: all is done."""


Outcome: TypeAlias = tuple[Ticket, Callable[[], None]]


class Jobs:
    """The live slots and the long jobs of one editor; everything but the workers' part runs on the UI thread."""

    def __init__(
        self,
        *,
        wake: Callable[[], None] = lambda: None,
        live: Executor | None = None,
        long: Executor | None = None,
        beside: Executor | None = None,
    ) -> None:
        self.wake = wake
        """Called from workers when there is something to show or to hand over."""
        self._live = live or ThreadExecutor("live")
        self._long = long or ThreadExecutor("long")
        self._beside = beside or ThreadExecutor("beside")
        self._slots: dict[str, Ticket] = {}
        self._tickets: list[Ticket] = []
        self._outcomes: deque[Outcome] = deque()
        self._woken = False
        self._heard: deque[str] = deque()

    @classmethod
    def inline(cls) -> "Jobs":
        """Return jobs that are run where they are submitted, for tests and scripts."""
        return cls(live=InlineExecutor(), long=InlineExecutor(), beside=InlineExecutor())

    @property
    def long_jobs(self) -> tuple[Ticket, ...]:
        """The long jobs whose results are not handed over yet, the oldest first."""
        return tuple(self._tickets)

    @property
    def is_idle(self) -> bool:
        """Whether nothing runs, waits or is to be handed over."""
        return not self._slots and not self._tickets and not self._outcomes

    def submit(self, slot: str, task: Task[T], *, beside: bool = False) -> Ticket:
        """Run `task` in a slot; whatever the slot held is cancelled and its result dropped.

        Slots share the live thread; with `beside` a third one, for what nobody waits for.
        """
        self.drop(slot)
        ticket = self._slots[slot] = Ticket(task)
        (self._beside if beside else self._live).submit(lambda: self._work(ticket))
        return ticket

    def drop(self, slot: str) -> None:
        """Cancel what a slot holds."""
        if slot in self._slots:
            self._slots.pop(slot).cancel()

    def holds(self, slot: str) -> bool:
        """Whether a slot has work whose result is not handed over yet."""
        return slot in self._slots

    def start(self, task: Task[T], *, beside: bool = False) -> Ticket:
        """Queue `task` as a long job, visible in `long_jobs`; with `beside` it waits for none of the others."""
        ticket = Ticket(task)
        self._tickets.append(ticket)
        (self._beside if beside else self._long).submit(lambda: self._work(ticket))
        return ticket

    def cancel_all(self) -> None:
        """Cancel every long job."""
        for ticket in self._tickets:
            ticket.cancel()

    def drain(self, *, hold_edits: bool = False) -> int:
        """Hand over the results that are there and return how many; with `hold_edits`, not those that edit."""
        self._woken = False
        held: list[Outcome] = []
        handed = 0
        for _ in range(len(self._outcomes)):
            ticket, hand_over = self._outcomes.popleft()
            if hold_edits and ticket.task.edits and not ticket.cancelled:
                held.append((ticket, hand_over))
                continue
            self._forget(ticket)
            if not ticket.cancelled:
                _hand_over(ticket, hand_over)
                handed += 1
        self._outcomes.extendleft(reversed(held))
        return handed

    def take_notices(self) -> list[str]:
        """Return what jobs have said of their work since the last call: no faults, but worth knowing."""
        return [self._heard.popleft() for _ in range(len(self._heard))]

    def close(self) -> None:
        """Cancel everything and end the threads."""
        for slot in list(self._slots):
            self.drop(slot)
        self.cancel_all()
        self._live.close()
        self._long.close()
        self._beside.close()

    def _forget(self, ticket: Ticket) -> None:
        """Take a finished ticket off the books."""
        with contextlib.suppress(ValueError):
            self._tickets.remove(ticket)
        for slot, held in list(self._slots.items()):
            if held is ticket:
                del self._slots[slot]

    def _work(self, ticket: Ticket) -> None:
        """Run a task to its end, its cancellation or its fault; on the worker's thread."""
        task = ticket.task
        hand_over: Callable[[], None] = _nothing
        if ticket.cancelled:
            ticket.state = "cancelled"
        else:
            ticket.state = "running"
            try:
                with tracing.span("job", job=task.name), hear_notices() as heard:
                    result = self._steps(ticket)
                self._heard.extend(heard)
                hand_over = lambda: task.deliver(result)  # noqa: E731
                ticket.state = "cancelled" if ticket.cancelled else "finished"
            except Exception as fault:  # noqa: BLE001  it travels to the UI thread, which shows it
                caught = fault
                hand_over = lambda: task.fail(caught)  # noqa: E731
                ticket.state = "failed"
        self._outcomes.append((ticket, hand_over))
        self._wake_once()

    def _steps(self, ticket: Ticket) -> object:
        """Run the generator and return its result, None when it was cancelled on the way."""
        job = ticket.task.steps()
        try:
            while not ticket.cancelled:
                ticket.progress = next(job)
                if not ticket.task.quiet or ticket.progress.preview is not None:
                    self._wake_once()
        except StopIteration as end:
            return end.value
        job.close()
        return None

    def _wake_once(self) -> None:
        """Wake the UI thread unless it is still to answer the last call."""
        if not self._woken:
            self._woken = True
            self.wake()


def _hand_over(ticket: Ticket, hand_over: Callable[[], None]) -> None:
    """Hand a result over; where taking it fails, the task fails, and the results behind it are handed over still."""
    try:
        hand_over()
    except Exception as fault:  # noqa: BLE001  whoever waits for the result is told
        ticket.task.fail(fault)


def _nothing() -> None:
    """Hand nothing over."""
