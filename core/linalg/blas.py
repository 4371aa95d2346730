"""One thread for BLAS and OpenCV: on small blocks, their threads wait for one another longer than they work.

A limit is the whole process's. Who holds it is counted, so that it lasts until the last of several threads lets go.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager
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


def limit_blas() -> Callable[[], None]:
    """Hold BLAS to one thread; return what undoes that."""
    if all(library.num_threads == 1 for library in _libraries().lib_controllers):
        return lambda: None  # by the environment: to set what is set takes its time
    _take_control()
    undo: Callable[[], None] = _libraries().limit(limits=1).restore_original_limits

    def let_go() -> None:
        _take_control()
        undo()

    return let_go


def _take_control() -> None:
    """Let this thread set limits: those of any but the first one that did are passed over without a word."""
    for library in _libraries().lib_controllers:
        getattr(library, "clear_controlling_thread", lambda *, force: None)(force=True)


def limit_opencv() -> Callable[[], None]:
    """Hold OpenCV to one thread; return what undoes that."""
    import cv2

    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    return lambda: cv2.setNumThreads(before)


class _Hold:
    """A limit, and how many hold it; `limit` sets it and returns what undoes that."""

    def __init__(self, limit: Callable[[], Callable[[], None]]) -> None:
        self._lock, self._holders, self._limit = Lock(), 0, limit

    def __enter__(self) -> None:
        with self._lock:
            if self._holders == 0:
                self._undo = self._limit()
            self._holders += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._holders -= 1
            if self._holders == 0:
                self._undo()


_blas, _opencv = _Hold(limit_blas), _Hold(limit_opencv)


def one_thread() -> AbstractContextManager[None]:
    """Hold BLAS to one thread, whatever the caller's process has it use, for as long as the context lasts."""
    return _blas


def on_one_thread(job: Job[T]) -> Job[T]:
    """Run each step of `job` with BLAS and OpenCV held to one thread; between them they have as many as before."""
    while True:
        with _blas, _opencv:
            try:
                step = next(job)
            except StopIteration as end:
                result: T = end.value
                return result
        yield step
