"""What a user should know of work that goes on nevertheless, such as metadata that a file cannot hold.

Faults are exceptions; notices are for what is no fault. Who does the work says it with `notice`, whoever asked for the
work hears it with `hear_notices`: the command line writes it out, the window shows it.
"""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_log = logging.getLogger("weft")
_listener: ContextVar[list[str] | None] = ContextVar("listener", default=None)


def notice(text: str) -> None:
    """Say `text`, one line, to who listens on this thread; where nobody does, to the log."""
    heard = _listener.get()
    if heard is None:
        _log.warning(text)
    elif text not in heard:
        heard.append(text)


@contextmanager
def hear_notices() -> Iterator[list[str]]:
    """Yield the list that takes the notices of the block, on this thread."""
    heard: list[str] = []
    token = _listener.set(heard)
    try:
        yield heard
    finally:
        _listener.reset(token)
