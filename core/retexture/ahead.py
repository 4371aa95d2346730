"""Results that are made in other threads before they are asked for."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

S = TypeVar("S")
T = TypeVar("T")
AHEAD = 2
"""Results made meanwhile."""


def ahead(make: Callable[[S], T], given: Iterable[S]) -> Iterator[T]:
    """Yield what `make` makes of each thing `given`, in their order."""
    with ThreadPoolExecutor(AHEAD) as threads:
        making: deque[Future[T]] = deque()
        for thing in given:
            making.append(threads.submit(make, thing))
            if len(making) > AHEAD:
                yield making.popleft().result()
        for rest in making:
            yield rest.result()
