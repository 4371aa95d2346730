"""Interrupts while modules load: libraries in C++ abort on an exception then, or lose it."""

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def loading() -> Iterator[None]:
    """Have an interrupt end the process at once, with status 130, for as long as the block does nothing but load."""
    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    signal.signal(signal.SIGINT, _leave)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _leave(_number: int, _frame: object) -> None:
    sys.stderr.write("weft: interrupted\n")
    sys.stderr.flush()
    os._exit(130)
