"""Seconds spent per stage of a mapping, as reports and timing tables need them."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from core.tracing import span


class Stopwatch:
    """Adds up seconds by stage; every measurement is a span of the timeline too."""

    def __init__(self) -> None:
        self._seconds: dict[str, float] = {}

    @contextmanager
    def measure(self, stage: str) -> Iterator[None]:
        """Add the time of the block to `stage`."""
        started = time.perf_counter()
        try:
            with span(stage):
                yield
        finally:
            self._seconds[stage] = self._seconds.get(stage, 0.0) + time.perf_counter() - started

    def take(self) -> dict[str, float]:
        """Return the seconds since the last call and start again from zero."""
        taken, self._seconds = self._seconds, {}
        return taken
