"""One thread for BLAS: on small blocks, its threads wait for one another longer than they work."""

from contextlib import AbstractContextManager
from typing import TypeVar

import numpy as np  # noqa: F401  loads the library to be found
import scipy.linalg  # noqa: F401
from threadpoolctl import ThreadpoolController

from core.progress import Job

T = TypeVar("T")

_LIBRARIES = ThreadpoolController().select(user_api="blas")


def one_thread() -> AbstractContextManager[object]:
    """Hold BLAS to one thread, whatever the caller's process has it use, for as long as the context lasts."""
    limited: AbstractContextManager[object] = _LIBRARIES.limit(limits=1)
    return limited


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
