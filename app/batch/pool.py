"""Chunks on the cores of this machine: processes that outlive a chunk, and what becomes of it when one is killed."""

import atexit
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace

from app.batch.plan import Chunk
from app.batch.records import Row
from app.batch.work import do_chunk

Tell = Callable[[Sequence[Row]], None]


def run_here(chunks: Sequence[Chunk], jobs: int, tell: Tell) -> None:
    """Do the chunks in `jobs` processes, and `tell` the rows of each.

    When a process is killed, what it had not done is done by others. What kills a process when it has the machine to
    itself is taken for a fault of that frame.
    """
    left = _passed(_passed(chunks, jobs, tell), jobs, tell)
    for chunk in left:
        alone = [chunk] if chunk.batch.writes_video else [replace(chunk, items=(item,)) for item in chunk.items]
        for part in alone:
            for broken in _passed([part], 1, tell):
                fault = "the process that drew it was killed"
                tell([Row(item.frame, item.source, item.output, "failed", fault=fault) for item in broken.items])


def _passed(chunks: Sequence[Chunk], jobs: int, tell: Tell) -> list[Chunk]:
    """Do the chunks until a process is killed; return those that are not done, to be gone on with."""
    left = list(chunks)
    if not left:
        return left
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(jobs, len(left)), mp_context=context, initializer=_follow)
    try:
        doing = {pool.submit(do_chunk, chunk): chunk for chunk in left}
        for future in as_completed(doing):
            rows = future.result()
            left.remove(doing[future])
            tell(rows)
    except BrokenProcessPool:
        pool.shutdown(wait=True, cancel_futures=True)
        return [replace(chunk, batch=replace(chunk.batch, resume=True)) for chunk in left]
    except BaseException:
        for child in multiprocessing.active_children():
            child.terminate()
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()
    return []


def _follow() -> None:
    """Have this process end when the one that began it does, and leave interrupts to that.

    At its own end it just ends: taken down piece by piece, OpenImageIO's binding complains on standard error.
    """
    atexit.register(os._exit, 0)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def end() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=end, daemon=True).start()
