"""Seconds spent per stage, as reports and timing tables need them."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from core.tracing import span


class Stopwatch:
    """Adds up seconds by stage; every measurement is a span of the timeline too."""

    def __init__(self, *stages: str) -> None:
        self.seconds = dict.fromkeys(stages, 0.0)
        """By stage, since the last `take`; stages that are named at the start are there from the start."""
        self._started = time.perf_counter()

    @property
    def total(self) -> float:
        """Seconds since the stopwatch was made."""
        return time.perf_counter() - self._started

    @contextmanager
    def measure(self, stage: str) -> Iterator[None]:
        """Add the time of the block to `stage`."""
        started = time.perf_counter()
        try:
            with span(stage):
                yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - started

    def take(self) -> dict[str, float]:
        """Return the seconds since the last call and start again from zero."""
        taken, self.seconds = self.seconds, {}
        return taken
