"""A large picture worked on some rows at a time, so that what is computed on the way fits in memory, on two cores."""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")

ROWS = 256
"""Most rows of a band."""
PIXELS = 131_072
"""Pixels of a band of a wide picture: what is computed of them stays near the processor, and its memory is kept."""


def bands(shape: tuple[int, ...], margin: int) -> Iterator[tuple[int, int, int, int]]:
    """Yield the bands of a picture (H, W): where what is read begins, the band begins and ends, and what is read ends.

    A `margin` of so many rows is read to both sides, of narrow bands no more than a quarter as much as they have.
    """
    count, rows = shape[0], min(max(PIXELS // max(shape[1], 1), 8 * margin, 1), ROWS)
    for top in range(0, count, rows):
        bottom = min(top + rows, count)
        yield max(top - margin, 0), top, bottom, min(bottom + margin, count)


def in_bands(work: Callable[[int, int, int, int], T], shape: tuple[int, ...], margin: int = 0) -> list[T]:
    """Return what comes of the work on each of the bands, two of which are worked on at a time."""
    with ThreadPoolExecutor(2) as workers:
        return list(workers.map(work, *zip(*bands(shape, margin), strict=True)))
