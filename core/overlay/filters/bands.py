"""A large picture worked on a hundred rows at a time, so that what is computed on the way fits in memory."""

from collections.abc import Iterator

ROWS = 128


def bands(count: int, margin: int) -> Iterator[tuple[int, int, int, int]]:
    """Yield the bands of so many rows: where what is read begins, the band begins and ends, and what is read ends."""
    for top in range(0, count, ROWS):
        bottom = min(top + ROWS, count)
        yield max(top - margin, 0), top, bottom, min(bottom + margin, count)
