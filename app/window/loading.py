"""Interrupts while modules load: libraries in C++ abort on an exception then, or lose it.

Nor is garbage collected: what modules define stays, and looking through it again and again takes a tenth of the time.
"""

import atexit
import gc
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

atexit.register(gc.unfreeze)  # else libraries say that it was lost


@contextmanager
def loading() -> Iterator[None]:
    """Have an interrupt end the process at once, with status 130, for as long as the block does nothing but load."""
    is_main, collects = threading.current_thread() is threading.main_thread(), gc.isenabled()
    interrupts = is_main and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    gc.disable()
    if interrupts:
        signal.signal(signal.SIGINT, _leave)
    try:
        yield
    finally:
        if interrupts:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        gc.freeze()
        if collects:
            gc.enable()


def _leave(_number: int, _frame: object) -> None:
    sys.stderr.write("weft: interrupted\n")
    sys.stderr.flush()
    os._exit(130)
