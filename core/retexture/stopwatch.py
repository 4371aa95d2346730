"""Seconds by stage, and the same stages on the timeline."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from core.tracing import span


class Stopwatch:
    """Sums the time spent in each stage."""

    def __init__(self, *stages: str) -> None:
        self.seconds = dict.fromkeys(stages, 0.0)
        self._started = time.perf_counter()

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Add the time that the block takes to `stage`."""
        started = time.perf_counter()
        try:
            with span(stage):
                yield
        finally:
            self.seconds[stage] += time.perf_counter() - started

    @property
    def total(self) -> float:
        """Seconds since the stopwatch was made."""
        return time.perf_counter() - self._started
