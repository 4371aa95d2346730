"""Chunks on the cores of this machine: processes that outlive a chunk, and what becomes of it when one is killed.

They are spoken to through pipes alone: the queues of `concurrent.futures` have named semaphores, which stay in the
system when all of a batch's processes are killed together, and its pool ends every process when one is killed.
"""

import contextlib
import multiprocessing
import os
import signal
import threading
from collections import Counter, deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess

from app.batch.plan import Chunk
from app.batch.records import Row
from app.batch.work import do_chunk

Tell = Callable[[Sequence[Row]], None]
_TRIALS = 2
"""How many processes a chunk, and then each of its frames alone, may cost."""


@dataclass
class _Worker:
    """A process and what it is doing."""

    process: SpawnProcess
    connection: Connection
    chunk: Chunk | None = None


def run_here(chunks: Sequence[Chunk], jobs: int, tell: Tell) -> None:
    """Do the chunks in `jobs` processes, and `tell` the rows of each.

    When a process is killed, what it had not done is done by another one; a frame that costs one process after another
    has failed.
    """
    waiting, losses = deque(chunks), Counter[tuple[int, int, int]]()
    workers = [_begin() for _ in range(min(jobs, len(waiting)))]
    try:
        while waiting or any(worker.chunk is not None for worker in workers):
            for worker in workers:
                if worker.chunk is None and waiting:
                    worker.chunk = waiting.popleft()
                    with contextlib.suppress(OSError):  # killed while it was idle, which the next answer tells
                        worker.connection.send(worker.chunk)
            ready = wait([worker.connection for worker in workers if worker.chunk is not None])
            for place, worker in enumerate(workers):
                chunk = worker.chunk
                if worker.connection in ready and chunk is not None:
                    try:
                        _take(worker.connection.recv(), tell)
                        worker.chunk = None
                    except (EOFError, ConnectionError):
                        waiting.extend(_again(chunk, losses, tell))
                        workers[place] = _begin()
    finally:
        for worker in workers:
            worker.connection.close()
            worker.process.terminate()
        for worker in workers:
            worker.process.join()


def _begin() -> _Worker:
    """Begin a process."""
    context = multiprocessing.get_context("spawn")
    ours, its = context.Pipe()
    process = context.Process(target=_serve, args=(its,), daemon=True)
    process.start()
    its.close()
    return _Worker(process, ours)


def _take(answer: list[Row] | BaseException, tell: Tell) -> None:
    """Tell the rows of a chunk; raise what kept it from being done."""
    if isinstance(answer, BaseException):
        raise answer
    tell(answer)


def _again(chunk: Chunk, losses: Counter[tuple[int, int, int]], tell: Tell) -> list[Chunk]:
    """Return what is to be done of a chunk whose process was killed: all that is left, then frame by frame."""
    key = chunk.number, chunk.items[0].frame, len(chunk.items)
    losses[key] += 1
    rest = replace(chunk, batch=replace(chunk.batch, resume=True))
    if losses[key] < _TRIALS:
        return [rest]
    if len(chunk.items) > 1 and not chunk.batch.writes_video:
        return [replace(rest, items=(item,)) for item in chunk.items]
    fault = "the process that drew it was killed, again and again"
    tell([Row(item.frame, item.source, item.output, "failed", fault=fault) for item in chunk.items])
    return []


def _serve(connection: Connection) -> None:
    """Do the chunks that come, until no more can; end when the process that began this one does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def follow() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()
    with contextlib.suppress(EOFError, OSError):
        while True:
            chunk = connection.recv()
            try:
                answer: list[Row] | BaseException = do_chunk(chunk)
            except Exception as fault:  # noqa: BLE001  it is raised again where it is heard
                answer = fault
            connection.send(answer)
    os._exit(0)  # taken down piece by piece, OpenImageIO's binding complains on standard error
