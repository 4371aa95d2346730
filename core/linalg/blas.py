"""One thread for BLAS: on small blocks, its threads wait for one another longer than they work.

The limit is the whole process's. Who holds it is counted, so that it lasts until the last of several threads lets go.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import TypeVar

from threadpoolctl import ThreadpoolController

from core.progress import Job

T = TypeVar("T")


@cache
def _libraries() -> ThreadpoolController:
    """Return the libraries that there are, loaded to be found; not before they are used, since that takes its time."""
    import cv2  # noqa: F401
    import numpy as np  # noqa: F401
    import scipy.linalg  # noqa: F401

    return ThreadpoolController().select(user_api="blas")


class _Hold:
    """The limit and how many hold it."""

    def __init__(self) -> None:
        self._lock, self._holders = Lock(), 0

    def take(self) -> None:
        with self._lock:
            if self._holders == 0:
                self._limiter = _libraries().limit(limits=1)
            self._holders += 1

    def let_go(self) -> None:
        with self._lock:
            self._holders -= 1
            if self._holders == 0:
                self._limiter.restore_original_limits()


_hold = _Hold()


@contextmanager
def one_thread() -> Iterator[None]:
    """Hold BLAS to one thread, whatever the caller's process has it use, for as long as the context lasts."""
    _hold.take()
    try:
        yield
    finally:
        _hold.let_go()


def on_one_thread(job: Job[T]) -> Job[T]:
    """Run each step of `job` with BLAS held to one thread; between them it has as many as before."""
    while True:
        with one_thread():
            try:
                step = next(job)
            except StopIteration as end:
                result: T = end.value
                return result
        yield step
