"""Signals that end the window: Ctrl+C in the terminal, a log-out, `kill`."""

import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

ENDS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


@contextmanager
def interruptions(wake: Callable[[], None]) -> Iterator[threading.Event]:
    """Yield an event that Ctrl+C in the terminal, a log-out or `kill` sets, in the middle of no frame.

    `wake`, which ends the sleep of the frame loop, is called from another thread.
    """
    interrupted = threading.Event()
    heard, told = socket.socketpair()
    told.setblocking(False)

    def listen() -> None:
        with heard:
            while heard.recv(1):
                wake()

    threading.Thread(target=listen, name="signals", daemon=True).start()
    wakeup_before = signal.set_wakeup_fd(told.fileno(), warn_on_full_buffer=False)
    handlers_before = {number: signal.signal(number, lambda *_: interrupted.set()) for number in ENDS}
    try:
        yield interrupted
    finally:
        for number, handler in handlers_before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(wakeup_before)
        told.close()
