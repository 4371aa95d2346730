"""Lattices without doubled vertices from a piece of cloth whose coordinates come twice.

Around a fold that hides some of the pattern a piece is followed on both sides. Where the sides meet again, the number
of texels on the two ways need not agree, and one texel may lie at two places of the photo. These are vertices of two
sheets, each a lattice of its own.
"""

from collections import deque

import numpy as np
import scipy

from core.arrays import Ints
from core.overlay.detection.lattice import NEIGHBOURS, Lattice

Key = tuple[int, int]

FURTHEST = 0.5
"""Texels between two places from which they are not the same, or not a step away from each other."""

FURTHEST_SHIFT = 12
"""Texels by which a sheet may be moved, before it is put beyond all others."""

LEAST_AREA = 1e-3
"""Area of a texel, square pixels, under which vectors say nothing: those of two places may be opposite."""


def lay_apart(found: Lattice) -> Lattice:
    """Return the vertices, each once, with the coordinates of sheets that would meet others moved by whole texels."""
    kept = split_sheets(found)
    keys = [found.keys[kept[0]]] if kept else [found.keys]
    for rows in kept[1:]:
        keys.append(found.keys[rows] + free_shift(found.keys[rows], np.concatenate(keys)))
    return Lattice(np.concatenate(keys), found[np.concatenate(kept)].frames if kept else found.frames)


def free_shift(keys: Ints, taken: Ints) -> Ints:
    """Return the least shift (2,) that leaves vertices (n, 2) none next to those taken: they would be one sheet."""
    t = np.arange(-FURTHEST_SHIFT, FURTHEST_SHIFT + 1)
    around = np.stack(np.meshgrid(t, t), -1).reshape(-1, 2)
    tree = scipy.spatial.cKDTree(taken)
    for shift in around[np.argsort(np.linalg.norm(around, axis=1), kind="stable")]:
        distance, _ = tree.query(keys + shift, p=np.inf, distance_upper_bound=1.5)
        if not np.isfinite(distance).any():
            return np.asarray(shift, np.int64)
    return np.array([taken[:, 0].max() + 2 - keys[:, 0].min(), 0])


def split_sheets(found: Lattice) -> list[list[int]]:
    """Return the rows of each connected set of vertices in which none comes twice, largest first.

    Of several rows for the same vertex at one place one is kept.
    """
    rows_of: dict[Key, list[int]] = {}
    for row, (i, j) in enumerate(found.keys.tolist()):
        rows_of.setdefault((i, j), []).append(row)
    left, out = dict.fromkeys(range(len(found))), []
    while left:
        sheet = sheet_from(found, next(iter(left)), left, rows_of)
        for row in sheet:
            for other in rows_of[key_of(found, row)]:
                if other in left and is_step(found, row, other, (0, 0)):
                    del left[other]
        out.append(sheet)
    return sorted(out, key=len, reverse=True)


def sheet_from(found: Lattice, start: int, left: dict[int, None], rows_of: dict[Key, list[int]]) -> list[int]:
    """Return the rows among those left that are reached from `start` step by step and agree with all next to them."""
    taken, waiting = {key_of(found, start): start}, deque([start])
    while waiting:
        row = waiting.popleft()
        for near, step in next_to(key_of(found, row)):
            for other in rows_of.get(near, ()):
                fits = near not in taken and other in left and is_step(found, row, other, step)
                if fits and agrees(found, other, taken):
                    taken[near] = other
                    waiting.append(other)
    return list(taken.values())


def next_to(key: Key) -> list[tuple[Key, Key]]:
    """Return the four keys next to a key, each with the step to it."""
    return [((key[0] + i, key[1] + j), (i, j)) for i, j in NEIGHBOURS.tolist()]


def agrees(found: Lattice, row: int, taken: dict[Key, int]) -> bool:
    """Return whether a vertex lies a step away from all those taken that are next to it."""
    return all(is_step(found, row, taken[near], step) for near, step in next_to(key_of(found, row)) if near in taken)


def key_of(found: Lattice, row: int) -> Key:
    """Return the integer coordinates of a vertex."""
    i, j = found.keys[row].tolist()
    return i, j


def is_step(found: Lattice, row: int, other: int, step: Key) -> bool:
    """Return whether one vertex lies where the mean of its and another one's vectors have it after a `step`."""
    (x, y), (x_other, y_other) = found.frames.points[row].tolist(), found.frames.points[other].tolist()
    mean = (found.frames.bases[row] + found.frames.bases[other]) / 2
    (a, b), (c, d) = mean.tolist()
    area = a * d - b * c
    if abs(area) < LEAST_AREA:
        return False
    right, down = x_other - x, y_other - y
    u, v = (d * right - b * down) / area - step[0], (a * down - c * right) / area - step[1]
    return bool(u * u + v * v < FURTHEST**2)
