"""Grids of unit steps: drawn out from nodes some steps apart, and the pixels that lie in them.

A pixel takes the node of its grid, refined to half steps, that falls on it, and adds its own distance from there in the
node's frame, which is orthonormal but for the grid's bends.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from core.arrays import Floats, Ints, Singles

STRIDE = 4
"""Distance of the nodes that grids are drawn out from, px: a power of two."""
AT_ONCE = 16
"""Grids in which pixels are looked for at a time: what belongs to them stays in the processor's cache."""


def fill(grids: Singles, *, spine: int, rib: int) -> Singles:
    """Return grids (n, K, J, 2) of nodes `STRIDE` px apart with one at every px, as far as `rib` and `spine` only.

    The nodes between lie on cubics: (n, 2 rib + 1, 2 spine + 1, 2).
    """
    return _interpolated(grids, _between(grids.shape[1], rib), _for_pairs(_between, grids.shape[2], spine))


def locate(grids: Singles, corners: Ints, size: int, *, spine: int, rib: int) -> tuple[Ints, Ints, Singles]:
    """Return which pixels of windows lie in their grids (n, K, J, 2) of nodes `STRIDE` px apart, and where.

    Window i has `size` x `size` pixels from corners[i] on. Returned are numbers of grids (m,), in order, numbers of
    pixels (m,) in the flattened window, and their places (m, 2) as (j, k) from the first node of the `fill` grid.
    """
    parts = [
        _locate(grids[i : i + AT_ONCE] - corners[i : i + AT_ONCE, None, None].astype(np.float32), size, spine, rib)
        for i in range(0, max(len(grids), 1), AT_ONCE)
    ]
    number = np.repeat(np.arange(len(grids)), np.concatenate([part[0] for part in parts]))
    return number, np.concatenate([part[1] for part in parts]), np.concatenate([part[2] for part in parts])


def _locate(grids: Singles, size: int, spine: int, rib: int) -> tuple[Ints, Ints, Singles]:
    """Return for windows at (0, 0) how many pixels (n,) lie in their grids, which, and where, see `locate`."""
    fine = _interpolated(grids, _halves(grids.shape[1], rib), _for_pairs(_halves, grids.shape[2], spine))
    count, rows, columns = fine.shape[:3]
    on = np.rint(fine)
    within = ((on >= 0) & (on < size)).all(axis=-1) if on.min(initial=0) < 0 or on.max(initial=0) >= size else None
    pixel = (on @ np.array([1, size], np.float32)).astype(np.int64)
    pixel += (size * size * np.arange(count))[:, None, None]
    if within is not None:
        pixel[~within] = count * size * size
    node = np.full(count * size * size + 1, -1, np.int32)
    node[pixel.ravel()] = np.arange(pixel.size, dtype=np.int32)
    held = np.flatnonzero(node[:-1] >= 0)
    counts = np.diff(np.searchsorted(held, size * size * np.arange(count + 1)))
    first, chosen = np.repeat(np.arange(count), counts), node.take(held).astype(np.int64)
    in_window, in_grid = held - size * size * first, chosen - rows * columns * first
    nodes = as_complex(fine)
    gap = _pixels(size).take(in_window) - nodes.ravel().take(chosen)
    # Turned into the frame of the node at a whole step before.
    frame, at = _nodes(rows, columns)
    way = _unit_steps(nodes[:, ::2, ::2])
    gap *= way.ravel().take(frame.take(in_grid) + way[0].size * first)
    return counts, in_window, as_pairs(gap + at.take(in_grid))


def _unit_steps(nodes: NDArray[np.complex64]) -> NDArray[np.complex64]:
    """Return the conjugate unit tangents of rows of nodes (n, K, J)."""
    way = np.empty_like(nodes, order="C")
    np.subtract(nodes[..., 2:], nodes[..., :-2], out=way[..., 1:-1])
    np.subtract(nodes[..., 1], nodes[..., 0], out=way[..., 0])
    np.subtract(nodes[..., -1], nodes[..., -2], out=way[..., -1])
    return np.conj(way / np.maximum(np.abs(way), np.float32(1e-6)))


@cache
def _pixels(size: int) -> NDArray[np.complex64]:
    """Return the positions of the pixels of a flattened window."""
    y, x = np.divmod(np.arange(size * size), size)
    return (x + 1j * y).astype(np.complex64)


@cache
def _nodes(rows: int, columns: int) -> tuple[Ints, NDArray[np.complex64]]:
    """Return for nodes of a flattened grid in half steps that of the one in whole steps, and their places (j, k)."""
    k, j = np.divmod(np.arange(rows * columns), columns)
    return k // 2 * (columns // 2 + 1) + j // 2, ((j + 1j * k) / 2).astype(np.complex64)


def _interpolated(grids: Singles, down: Singles, across: Singles) -> Singles:
    """Return grids (n, K, J, 2) at places between their nodes, by weights (K', K) and, for pairs, (2 J, 2 J')."""
    count, rows, columns = grids.shape[:3]
    wide = grids.reshape(count * rows, 2 * columns) @ across
    fine: Singles = np.matmul(down, wide.reshape(count, rows, -1))
    return fine.reshape(count, len(down), -1, 2)


@cache
def _for_pairs(weights: Callable[[int, int], Singles], count: int, half: int) -> Singles:
    """Return the transpose of what `weights` makes of these, for rows of pairs."""
    return np.asarray(np.kron(weights(count, half).T, np.eye(2, dtype=np.float32)))


@cache
def _between(count: int, half: int) -> Singles:
    """Return the weights (2 half + 1, count) of `count` nodes, `STRIDE` apart, in nodes as far as `half` px."""
    weights, apart = np.eye(count), STRIDE
    while apart > 1:
        weights, apart = _halve(weights, cubic=True), apart // 2
    first = len(weights) // 2 - half
    return weights[first : first + 2 * half + 1].astype(np.float32)


@cache
def _halves(count: int, half: int) -> Singles:
    """Return the same (4 half + 1, count) with nodes halfway between these."""
    return _halve(_between(count, half), cubic=False).astype(np.float32)


def _halve(weights: Floats | Singles, *, cubic: bool) -> Floats:
    """Return rows (n, m) with another halfway between each two: the mean of both, or on a `cubic` through four."""
    fine = np.repeat(weights.astype(np.float64), 2, axis=0)[:-1]
    fine[1::2] = (weights[1:] + weights[:-1]) / 2
    if cubic and len(weights) > 2:
        bend = np.diff(weights, 2, axis=0) / 16
        fine[1:-3:2] -= bend
        fine[3::2] -= bend
        fine[1] -= bend[0]
        fine[-2] -= bend[-1]
    return fine


def as_complex(vectors: Singles) -> NDArray[np.complex64]:
    """Return vectors (..., 2) as complex numbers (...), which arithmetic goes through several times as fast."""
    return np.ascontiguousarray(vectors, np.float32).view(np.complex64)[..., 0]


def as_pairs(numbers: NDArray[np.complex64]) -> Singles:
    """Return complex numbers (...) as vectors (..., 2)."""
    return np.ascontiguousarray(numbers).view(np.float32).reshape(*numbers.shape, 2)
