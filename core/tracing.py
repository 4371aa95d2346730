"""A timeline of what the program did, in the Chrome trace event format.

`span("solve")` around a piece of work costs a few hundred nanoseconds while nobody records. One recorder serves the
whole process, since a timeline is of a process; spans may come from any thread. Beside its duration every span has its
thread's processor time, which says what the work costs while other programs are busy too.
"""

import json
import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_events: list[dict[str, object]] | None = None


def start() -> None:
    """Begin to record, forgetting what was recorded before."""
    global _events  # noqa: PLW0603  one timeline per process
    _events = []


def events() -> list[dict[str, object]]:
    """Return the recorded events, oldest first by their end."""
    return list(_events or [])


@contextmanager
def span(name: str, **arguments: object) -> Iterator[None]:
    """Record the time that the block takes under `name`; `arguments` are shown beside it."""
    if _events is None:
        yield
        return
    started, busy = time.perf_counter_ns(), time.thread_time_ns()
    try:
        yield
    finally:
        if _events is not None:
            _events.append(
                {
                    "name": name,
                    "ph": "X",
                    "ts": started / 1e3,
                    "dur": (time.perf_counter_ns() - started) / 1e3,
                    "tts": busy / 1e3,
                    "tdur": (time.thread_time_ns() - busy) / 1e3,
                    "pid": os.getpid(),
                    "tid": threading.get_native_id(),
                    "args": arguments,
                }
            )


def save(path: Path) -> None:
    """Write what was recorded to `path`; times are in microseconds."""
    path.write_text(json.dumps({"traceEvents": events(), "displayTimeUnit": "ms"}), encoding="utf-8")
