"""Whole texels by which places of sure cloth are moved, so that it is pinched nowhere.

Beside a seam or a fold, a mesh that went around it may count a row of texels too many, and is squeezed or stretched
where it meets itself, often across cloth that the photo shows whole. What it shows there is right but for whole texels.
Small squares of the cloth are compared with those a few steps away, in the directions in which it goes on around them:
with d by how much a pair misses, and n the whole texels that each is moved by, minimised is

    Σ w |S (d + n' - n)| + h Σ |S (n' - n)|,

the second sum over squares side by side that were followed as one. It is the sum of absolute values of phase unwrapping
(Costantini 1998), and found move by move through the cheapest cut of a graph (Bioucas-Dias and Valadão 2007): what is
left to tear tears where the cloth is seen least.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.arrays import Bools, Floats, Ints
from core.graphs.minimum_cut import LEAST_COST, minimum_cut
from core.overlay.filters.distances import nearest_of, within
from core.overlay.filters.texture_filter import steepness
from core.overlay.neighbours import STEPS

SIDE, FULL = 0.6, 0.4
"""Side of a square, in lattice steps, and how much of it is sure."""
AROUND = 2
"""Squares around one that tell its usual slopes."""
LENGTHS = (1, 2, 4)
"""Steps, straight or slanting, from one square of a pair to the other."""
UNSEEN = 0.25
"""Weight of a pair between which nothing is sure."""
BENT = 0.25
"""Lattice steps by which the slopes at both ends lead apart, over which a pair says little."""
HELD = 0.5
"""h."""
MOVES = (16, 4, 1)
"""Texels by which parts of the cloth are moved at a time."""
ROUNDS = 30
"""Most times that each of them is tried."""


@dataclass(frozen=True)
class Squares:
    """Small squares of sure cloth, as many as `used` (h, w) has marks."""

    used: Bools
    own: Bools
    """(H, W), the pixels that they consist of."""
    sheet: Ints
    """(n,), the sheet that was followed as one."""
    share: Floats
    """(h, w), how much of each is sure."""
    at: Floats
    """(n, 2), row and column of the middle."""
    uv: Floats
    """(n, 2), texels there."""
    slopes: Floats
    """(n, 2, 2), usual slopes around of places in the undeformed cloth, by row and column."""


def unwrap(uv: Floats, sheet: Ints, torn: Bools, basis: Floats, step_px: float) -> tuple[Floats, Bools]:
    """Return by how many whole texels (H, W, 2) places are moved, and which of them (H, W) remain sure.

    `uv` (H, W, 2) are texels, `sheet` (H, W) the number from 1 of the sure cloth that was followed as one, 0 for none,
    `torn` (H, W) what lies beside a jump; `basis` (2, 2) is pixels of undeformed cloth a texel, `step_px` the side of a
    lattice step.
    """
    side = max(2, round(SIDE * step_px))
    squares = squares_of(uv, sheet, basis, side)
    if not squares.own.any():
        return np.zeros(uv.shape), sheet > 0
    moved, cut = least_missing(squares, basis, step_px)
    spread, apart = np.zeros((*squares.used.shape, 2)), np.zeros(squares.used.shape, bool)
    spread[squares.used], apart[squares.used] = moved, cut
    near = nearest_of(squares.own)[1]
    alike = (sheet > 0) & (sheet.ravel()[near] == sheet)
    beside = within(torn | (squares.own & by_pixels(apart, side, sheet.shape)), step_px)
    return by_pixels(spread, side, sheet.shape).reshape(-1, 2)[near], squares.own | (alike & ~beside)


def squares_of(uv: Floats, sheet: Ints, basis: Floats, side: int) -> Squares:
    """Return the squares of `side` pixels, each of the sheet that has most of it."""
    (h, w), size = sheet.shape, int(sheet.max()) + 1
    across = -(-w // side)
    shape = -(-h // side), across
    number = (np.arange(h) // side)[:, None] * across + np.arange(w) // side
    pairs, count = np.unique((number * size + sheet)[sheet > 0], return_counts=True)
    most = np.zeros(shape[0] * across, np.int64)
    np.maximum.at(most, pairs // size, count * size + pairs % size)
    owner, area = most % size, most // size
    used = area >= FULL * np.bincount(number.ravel(), minlength=len(most))
    own = (sheet > 0) & (sheet == owner[number]) & used[number]
    slopes = np.stack([steepness(np.where(own[..., None], uv @ basis.T, np.nan), axis) for axis in (0, 1)], -1)
    planes = np.concatenate([np.argwhere(own), uv[own], slopes[own].reshape(-1, 4)], -1)
    sums = np.stack([np.bincount(number[own], plane, len(most)) for plane in planes.T], -1)
    means = sums / np.maximum(area, 1)[:, None]
    usual = middle(means[:, 4:].reshape(*shape, 4), used.reshape(shape))
    return Squares(
        used.reshape(shape),
        own,
        owner[used],
        (area / side**2).reshape(shape),
        means[used, :2],
        means[used, 2:4],
        usual.reshape(-1, 2, 2),
    )


def middle(values: Floats, used: Bools) -> Floats:
    """Return the medians (n, k) of values (h, w, k) over the used squares around each used one."""
    padded = np.pad(
        np.where(used[..., None], values, np.nan), ((AROUND, AROUND), (AROUND, AROUND), (0, 0)), constant_values=np.nan
    )
    width = 2 * AROUND + 1
    windows = np.lib.stride_tricks.sliding_window_view(padded, (width, width), (0, 1))[used]
    ordered = np.sort(windows.reshape(-1, values.shape[-1], width**2), axis=-1)
    count = np.isfinite(ordered).sum(-1, keepdims=True)
    low, high = (np.take_along_axis(ordered, place, -1) for place in ((count - 1) // 2, count // 2))
    return np.asarray((low + high)[..., 0] / 2, np.float64)


def least_missing(squares: Squares, basis: Floats, step_px: float) -> tuple[Floats, Bools]:
    """Return the whole texels (n, 2) by which squares are moved, and which (n,) are torn from one beside them."""
    one, other, seen, beside = pairs_of(squares)
    way = squares.at[other] - squares.at[one]
    length = np.linalg.norm(way, axis=-1) / step_px
    first, last = squares.slopes[one], squares.slopes[other]
    # Where slopes differ, those lead that miss by least: what was followed stays unless it is surely wrong.
    missed = np.stack(
        [
            (squares.uv[other] - squares.uv[one]) @ basis.T - np.einsum("nij,nj->ni", led, way)
            for led in ((first + last) / 2, first, last)
        ]
    )
    missed = missed[np.linalg.norm(missed, axis=-1).argmin(0), np.arange(len(way))] / step_px
    apart = np.linalg.norm((first - last).reshape(-1, 4), axis=-1) * length / 2
    weight = (UNSEEN + (1 - UNSEEN) * seen) / np.maximum(length, 1e-6) / (1 + (apart / BENT) ** 2)
    held = np.where(beside, HELD, 0.0)
    moved, turns = np.zeros((len(squares.at), 2)), basis.T / step_px

    def costs(step: Floats) -> Floats:
        """Return what each pair costs whose second square is moved by so many texels more than the first."""
        by = step @ turns
        return np.asarray(weight * lengths(missed + by) + held * lengths(by))

    for size in MOVES:
        for _ in range(ROUNDS):
            gained = False
            for move in size * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]):
                now = moved[other] - moved[one]
                stay, second, first_only = costs(now), costs(now + move), costs(now - move)
                if (np.minimum(second, first_only) < stay - LEAST_COST).any():
                    chosen = cheapest(len(moved), one, other, second - stay, first_only - stay)
                    trial = moved + np.where(chosen[:, None], move, 0.0)
                    if costs(trial[other] - trial[one]).sum() < stay.sum() - LEAST_COST:
                        moved, gained = trial, True
            if not gained:
                break
    cut = beside & (moved[one] != moved[other]).any(-1)
    return moved, np.bincount(np.concatenate([one[cut], other[cut]]), minlength=len(moved)) > 0


def lengths(vectors: Floats) -> Floats:
    """Return the lengths (n,) of vectors (n, 2)."""
    return np.asarray(np.sqrt(np.einsum("nk,nk->n", vectors, vectors)), np.float64)


def pairs_of(squares: Squares) -> tuple[Ints, Ints, Floats, Bools]:
    """Return pairs of squares (m,), by number, how much is sure between them, and which lie side by side in a sheet."""
    (h, w), number = squares.used.shape, np.full(squares.used.shape, -1)
    number[squares.used] = np.arange(len(squares.at))
    found: list[tuple[Ints, Ints, Floats, Bools]] = []
    for down, across in (length * step for length in LENGTHS for step in STEPS):
        left, far = max(0, -across), max(down, abs(across))
        right = max(left, w - max(0, across))
        here, there = number[: max(h - down, 0), left:right], number[down:, left + across : right + across]
        rows, columns = np.nonzero((here >= 0) & (there >= 0))
        one, other = here[rows, columns], there[rows, columns]
        columns += left
        seen = np.ones(len(one))
        for k in range(1, far):
            seen = np.minimum(seen, squares.share[rows + round(down * k / far), columns + round(across * k / far)])
        found.append((one, other, seen, (far == 1) & (squares.sheet[one] == squares.sheet[other])))
    one, other, seen, beside = (np.concatenate(column) for column in zip(*found, strict=True))
    return one, other, seen, beside


def cheapest(size: int, one: Ints, other: Ints, second: Floats, first: Floats) -> Bools:
    """Return which of the squares move: pairs cost so much if only the second or the first does, else nothing.

    One of them may be a gain, and the other costs as much at least. The gain is told as costs of the single squares, so
    that the flow of the cut begins and ends at what gains alone, which is little.
    """
    second, first = (np.rint(costs / LEAST_COST) for costs in (second, first))
    gain = np.minimum(second, 0) - np.minimum(first, 0)
    alone = np.bincount(other, gain, size) - np.bincount(one, gain, size)
    between, back = np.maximum(second - gain, 0), np.maximum(first + gain, 0)
    return minimum_cut(one, other, between, np.maximum(alone, 0), np.maximum(-alone, 0), back)


def by_pixels(values: NDArray[Any], side: int, shape: tuple[int, ...]) -> NDArray[Any]:
    """Return values of squares (h, w, ...) at the pixels of a picture of that shape (H, W)."""
    return np.repeat(np.repeat(values, side, 0), side, 1)[: shape[0], : shape[1]]
