"""How long something takes."""

import statistics
import time
from collections.abc import Callable


def median_s(work: Callable[[], object], runs: int) -> float:
    """Return the median of the seconds that so many runs of `work` take."""
    taken = []
    for _ in range(runs):
        started = time.perf_counter()
        work()
        taken.append(time.perf_counter() - started)
    return statistics.median(taken)
