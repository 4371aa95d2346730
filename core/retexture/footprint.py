"""The pixels that patches cover, and which of them are neighbours: found before anything is known of their colours."""

from dataclasses import dataclass

import numpy as np

from core.arrays import Ints


@dataclass(frozen=True, eq=False)
class Footprint:
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


def footprints(patch: Ints, pixel: Ints, first: Ints, size: tuple[int, ...]) -> list[Footprint]:
    """Return footprints in a picture of `size`, (H, W), of the pixels from each of `first` (n + 1,) up to the next.

    `pixel` (m,) are numbers of pixels, no two alike in one patch, `patch` (m,) the patches that cover them, in order.
    """
    whole = _neighbours(patch, pixel, size)
    pairs, edges = np.searchsorted(whole.one, first), np.searchsorted(whole.edge, first)
    parts = []
    for i, start in enumerate(first[:-1]):
        pair, edge = slice(pairs[i], pairs[i + 1]), slice(edges[i], edges[i + 1])
        parts.append(
            Footprint(
                pixel[start : first[i + 1]],
                whole.one[pair] - start,
                whole.other[pair] - start,
                whole.seam[pair],
                whole.edge[edge] - start,
                whole.edge_seam[edge],
            )
        )
    return parts


def _neighbours(patch: Ints, pixel: Ints, size: tuple[int, ...]) -> Footprint:
    """Return which pixels are neighbours in the same patch, and which of others, in the pixels' order."""
    height, width = size
    y, x = np.divmod(pixel, width)
    number, tall, wide = _windows(patch, y, x)
    window = np.full((int(patch.max(initial=0)) + 1) * tall * wide, -1, np.int32)
    window[number] = np.arange(len(pixel))
    steps = np.array([1, wide])
    after, before = window.take(number[:, None] + steps), window.take(number[:, None] - steps)
    pair = np.flatnonzero(after >= 0)
    one, plane = pair // 2, height * width
    # To the right, down, to the left and up.
    room = np.stack([x < width - 1, y < height - 1, x > 0, y > 0], axis=-1)
    side = np.flatnonzero(room & (np.concatenate([after, before], axis=1) < 0))
    edge = side // 4
    seams = np.array([0, plane, -1, plane - width])
    return Footprint(
        pixel,
        one,
        after.ravel()[pair].astype(np.int64),
        pixel[one] + plane * (pair % 2),
        edge,
        pixel[edge] + seams[side % 4],
    )


def _windows(patch: Ints, y: Ints, x: Ints) -> tuple[Ints, int, int]:
    """Return the pixels' numbers (m,) in windows, one a patch, with a rim of a pixel, and the windows' sides."""
    if not len(patch):
        return patch, 1, 1
    first = np.flatnonzero(np.diff(patch, prepend=-1))
    count = np.diff(first, append=len(patch))
    inner = []
    for at in (y, x):
        low = np.minimum.reduceat(at, first)
        inner.append((at - np.repeat(low, count) + 1, int((np.maximum.reduceat(at, first) - low).max()) + 3))
    (down, tall), (right, wide) = inner
    return (patch * tall + down) * wide + right, tall, wide
