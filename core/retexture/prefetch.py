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


def prefetch(make: Callable[[S], T], given: Iterable[S], *, threads: int = AHEAD) -> Iterator[T]:
    """Return what `make` makes of each thing `given`, in their order, in `threads`; the first are begun at once."""
    rest, pool = iter(given), ThreadPoolExecutor(threads)
    begun = deque(pool.submit(make, thing) for thing in islice(rest, AHEAD))
    return _made(make, rest, pool, begun)


def _made(make: Callable[[S], T], rest: Iterator[S], pool: ThreadPoolExecutor, begun: deque[Future[T]]) -> Iterator[T]:
    with pool:
        while begun:
            made = begun.popleft().result()
            begun.extend(pool.submit(make, thing) for thing in islice(rest, 1))
            yield made
