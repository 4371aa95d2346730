"""The pixels that patches cover, and which of them are neighbours: found before anything is known of their colours."""

from dataclasses import dataclass

import numpy as np

from core.arrays import Bools, Ints


@dataclass(frozen=True, eq=False)
class PixelAdjacency:
    """m pixels that patches cover which do not touch, and all pairs of neighbours with at least one of them.

    Pairs are kept by what they are in `Canvas.seams`, flattened: from a pixel to its right neighbour, or its lower one.
    """

    pixel: Ints
    """(m,) numbers of pixels in the flattened picture."""
    one: Ints
    other: Ints
    """(p,) which pixels are neighbours, of the m."""
    seam: Ints
    """(p,) their pairs."""
    edge: Ints
    """(q,) which pixels are neighbours of others than the m, once for each."""
    edge_seam: Ints
    """(q,) their pairs."""


def find_adjacency(patch: Ints, pixel: Ints, size: tuple[int, ...]) -> PixelAdjacency:
    """Return the footprint of `pixel`s (m,), by their numbers in a picture of `size`, (H, W).

    `patch` (m,) are the patches that cover them, in order; none of these touch.
    """
    height, width = size
    plane = height * width
    y, x = np.divmod(pixel, width)
    number, window, wide = _windowed(patch, y, x)
    pairs, edges = [], []
    for step, seam, inside in ((1, 0, x < width - 1), (wide, plane, y < height - 1)):
        after = window.take(number + step)
        one = np.flatnonzero(after >= 0)
        pairs.append((one, after.take(one), pixel.take(one) + seam))
        edges.append(_edge(after, inside, pixel, seam))
    for step, seam, inside in ((-1, -1, x > 0), (-wide, plane - width, y > 0)):
        edges.append(_edge(window.take(number + step), inside, pixel, seam))
    one, other, between = (np.concatenate(parts) for parts in zip(*pairs, strict=True))
    edge, beyond = (np.concatenate(parts) for parts in zip(*edges, strict=True))
    return PixelAdjacency(pixel, one, other, between, edge, beyond)


def _edge(beside: Ints, inside: Bools, pixel: Ints, seam: int) -> tuple[Ints, Ints]:
    """Return which pixels have a neighbour `inside` the picture (m,) that is none `beside` them (m,), and the pairs."""
    edge = np.flatnonzero((beside < 0) & inside)
    return edge, pixel.take(edge) + seam


def _windowed(patch: Ints, y: Ints, x: Ints) -> tuple[Ints, Ints, int]:
    """Return the pixels' numbers (m,) in windows, one a patch, with a rim of a pixel; the windows; and their width.

    Windows hold the pixels' places among the m, and -1 elsewhere.
    """
    first = np.flatnonzero(np.diff(patch, prepend=-1))
    count = np.diff(first, append=len(patch))
    inner = []
    for at in (y, x):
        low = np.minimum.reduceat(at, first)
        inner.append((at - np.repeat(low, count) + 1, int((np.maximum.reduceat(at, first) - low).max()) + 3))
    (down, tall), (right, wide) = inner
    number = (np.repeat(np.arange(len(first)), count) * tall + down) * wide + right
    window = np.full(len(first) * tall * wide, -1)
    window[number] = np.arange(len(number))
    return number, window, wide
