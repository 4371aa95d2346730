"""Jobs in processes of their own, some at once: what they do holds no lock of this one, and ends when nobody wants it.

The main thread does its share: what it asks for before it is begun is done there. So are all jobs where there is no
more than one process. They come to the same in any.
"""

import os
import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, cast

from core.linalg.beside import Process, process_of_thread
from core.progress import Job, Progress, Steps, part

S = TypeVar("S")
T = TypeVar("T")

WAIT_S = 0.1
"""Who waits for a step hears of the last one again after so long, and can turn away."""


@dataclass(frozen=True)
class End(Generic[T]):
    """What a job has come to."""

    result: T


class JobThere(Generic[T]):
    """A job in the process that does it."""

    def __init__(self, make: Callable[..., Job[T]], *arguments: object) -> None:
        self._job = make(*arguments)

    def go_on(self) -> Progress | End[T]:
        """Return the next step, or the end."""
        try:
            return next(self._job)
        except StopIteration as end:
            return End(end.value)


class PlannedJob(Generic[T]):
    """A job that may be begun in another process: its result can be asked for before it is, too."""

    def __init__(self, threads: ThreadPoolExecutor | None, make: Callable[..., Job[T]], *arguments: object) -> None:
        self._threads, self._make, self._arguments = threads, make, arguments
        self._steps: deque[Progress | End[T] | Exception] = deque()
        self._news = threading.Condition()
        self._process: Process | None = None
        self._is_wanted = True
        self._turn: Future[None] | None = None

    def begin(self) -> None:
        """Begin the job if there are other processes, as soon as one of them is free."""
        if self._threads is not None and self._turn is None:
            self._turn = self._threads.submit(self._run)

    def result(self) -> Job[T]:
        """Return what the job does, or raise what it raises; to be asked for once."""
        if not is_main_thread():
            self.begin()
        elif self._turn is not None and self._turn.cancel():
            self._turn = None
        if self._turn is None:
            return (yield from self._make(*self._take_arguments()))
        last = Progress(0.0)
        while True:
            with self._news:
                self._news.wait_for(lambda: self._steps, WAIT_S)
                step = self._steps.popleft() if self._steps else last
            if isinstance(step, Exception):
                raise step
            if isinstance(step, End):
                result: T = step.result
                return result
            yield step
            last = step

    @property
    def is_begun(self) -> bool:
        """Whether it was begun in another process, or waits for one."""
        return self._turn is not None

    @property
    def is_over(self) -> bool:
        """Whether another process has come to its end."""
        with self._news:
            return bool(self._steps) and not isinstance(self._steps[-1], Progress)

    def stop(self) -> None:
        """End the job: nobody asks for its result any more."""
        self._is_wanted = False
        if self._turn is not None:
            self._turn.cancel()
        if (process := self._process) is not None:
            process.kill()

    def _run(self) -> None:
        """Run the job to its end, in this thread's other process if it has one, and keep what it says."""
        self._process = process = process_of_thread()
        try:
            go_on = self._starting_in(process)
            while self._is_wanted:
                step = go_on()
                self._tell(step)
                if isinstance(step, End):
                    return
        except Exception as fault:  # noqa: BLE001  it is raised where the result is asked for
            self._tell(fault)
        finally:
            self._process = None

    def _starting_in(self, process: Process | None) -> Callable[[], Progress | End[T]]:
        """Return what goes on with the job step by step."""
        if process is None:
            return JobThere(self._make, *self._take_arguments()).go_on
        job = process.make(JobThere, self._make, *self._take_arguments())
        return lambda: cast("Progress | End[T]", job.ask("go_on"))

    def _take_arguments(self) -> tuple[object, ...]:
        """Return what the job is for, and let go of it: planned jobs are kept as long as their pool."""
        taken, self._arguments = self._arguments, ()
        return taken

    def _tell(self, step: Progress | End[T] | Exception) -> None:
        with self._news:
            if self._steps and shows_the_same(self._steps[-1], step):
                self._steps.pop()
            self._steps.append(step)
            self._news.notify()


def run_meanwhile(
    first: PlannedJob[S], other: PlannedJob[T], is_to_go_on: Callable[[S], bool]
) -> Job[tuple[S, End[T] | None]]:
    """Return what the `first` job does, and the end of the `other` if that is to go on after it, else None.

    Where the first one has been begun in another process the other is done meanwhile, and stopped where it is not to go
    on: that is asked once, as soon as the first has ended.
    """
    there = iter(steps := Steps(part(other.result(), 0.4, 1.0)))
    if first.is_begun:
        for step in there:
            yield step
            if first.is_over:
                break
    result = yield from part(first.result(), 0.0, 0.4)
    if not is_to_go_on(result):
        other.stop()
        return result, None
    yield from there
    return result, End(steps.result)


def shows_the_same(one: object, other: object) -> bool:
    """Return whether two steps of a job show the same part of it: nobody needs more than the last of these."""
    if not (isinstance(one, Progress) and isinstance(other, Progress)):
        return False
    first, second = (getattr(step.preview, "name", None) for step in (one, other))
    return bool(first == second)


def is_main_thread() -> bool:
    """Return whether this is the thread that the program began with: what it waits for, nobody else does."""
    return threading.current_thread() is threading.main_thread()


@dataclass
class Allowed:
    """How many processes jobs may take, this one counted."""

    processes: int = 1


_allowed = Allowed()


@contextmanager
def use_all_processors() -> Iterator[None]:
    """Let jobs have a process for each processor as long as the context lasts; else they all have this one."""
    before, _allowed.processes = _allowed.processes, count_processors()
    try:
        yield
    finally:
        _allowed.processes = before


def count_processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class ProcessPool:
    """Processes for jobs, which begin in their order; all end with the context."""

    def __init__(self) -> None:
        processes = _allowed.processes
        self._threads = ThreadPoolExecutor(processes - is_main_thread()) if processes > 1 else None
        self._planned: list[PlannedJob[Any]] = []

    def __enter__(self) -> "ProcessPool":
        return self

    def __exit__(self, *_: object) -> None:
        if self._threads is not None:
            self._threads.shutdown(wait=False, cancel_futures=True)
        for planned in self._planned:
            planned.stop()

    @property
    def is_beside(self) -> bool:
        """Whether jobs run in processes of their own, some at once."""
        return self._threads is not None

    def plan(self, make: Callable[..., Job[T]], *arguments: object) -> PlannedJob[T]:
        """Return the job that `make`, a module's own function, returns for `arguments`, not begun yet."""
        planned = PlannedJob(self._threads, make, *arguments)
        if self._threads is not None:
            self._planned.append(planned)
        return planned

    def begin(self, make: Callable[..., Job[T]], *arguments: object) -> PlannedJob[T]:
        """Return a job as `plan` does, begun if there are other processes."""
        begun = self.plan(make, *arguments)
        begun.begin()
        return begun

    def run(self, make: Callable[..., Job[T]], *arguments: object) -> Job[T]:
        """Return what a job does as `plan` takes it."""
        return self.plan(make, *arguments).result()


HERE = ProcessPool()
"""No other process."""
