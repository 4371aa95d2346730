"""Results that are made in other threads before they are asked for."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice
from typing import TypeVar

S = TypeVar("S")
T = TypeVar("T")
AHEAD = 2
"""Results made meanwhile."""


def ahead(make: Callable[[S], T], given: Iterable[S]) -> Iterator[T]:
    """Return what `make` makes of each thing `given`, in their order; the first are begun at once."""
    rest, threads = iter(given), ThreadPoolExecutor(AHEAD)
    begun = deque(threads.submit(make, thing) for thing in islice(rest, AHEAD))
    return _made(make, rest, threads, begun)


def _made(
    make: Callable[[S], T], rest: Iterator[S], threads: ThreadPoolExecutor, begun: deque[Future[T]]
) -> Iterator[T]:
    with threads:
        while begun:
            made = begun.popleft().result()
            begun.extend(threads.submit(make, thing) for thing in islice(rest, 1))
            yield made
