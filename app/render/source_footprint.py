"""Which source pixels a part of the output reads, and by which filter."""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from app.render.programs import Names
from app.render.sources.source import Box
from core.arrays import Floats, Ints, Points

MOST_ANISOTROPY = 16.0
"""As in mesh.vert."""
LEAST_AREA = 1e-3
"""Triangles of a smaller area, in square output pixels, hit no pixel worth the pixels they would read."""
SUPPORT, NARROW_TEXELS = 4, 5
"""Of the kernel in texels where it does not shrink, and what a row of a narrow one has at most; as in filter.glsl."""
BLOCK = 16
"""Quads along the side of a block; triangles are looked for in blocks first."""
ROUNDING = 1.001
"""What a singular value decides is certain where so much more would decide it too: the shader's has fewer digits."""


class Read(NamedTuple):
    """What drawing a part of the output reads."""

    box: Box
    level: int
    """The finest of the pyramid."""
    top: int | None
    """The coarsest; None where it is not known."""
    filters: Names
    """Names that may be defined in filter.glsl: the one filter that is needed, whether its rows are short."""


@dataclass(frozen=True, eq=False)
class SourceFootprint:
    """The triangles of a mesh, T of them, block after block, and the singular values of their d(source) / d(output).

    All that is known of them has their number as its last axis, before it x and y: so each step is one pass.
    """

    rest: Floats
    """The first corner of each (2, T), in source pixels."""
    rest_low: Floats
    rest_high: Floats
    """The box around each (2, T)."""
    moved: Floats
    """The same in output pixels."""
    moved_low: Floats
    moved_high: Floats
    jacobian: Floats
    """(2, 2, T)"""
    major: Floats
    minor: Floats
    has_slivers: bool
    """Whether there are triangles besides these."""
    starts: Ints
    """The first triangle of each of B blocks, and T."""
    low: Floats
    high: Floats
    """The box around each block (2, B), in output pixels."""

    @classmethod
    def of(cls, rest: Points, moved: Points) -> "SourceFootprint":
        """Return the reach of a grid (R, C, 2) in source and output pixels."""
        block, order = _blocks((rest.shape[0] - 1, rest.shape[1] - 1), BLOCK)
        source, output = (_triangles(nodes).take(order, axis=-1) for nodes in (rest, moved))
        S, O = (p[1:] - p[0] for p in (source, output))  # (edge, x or y, T)
        det = O[0, 0] * O[1, 1] - O[0, 1] * O[1, 0]
        wide = np.flatnonzero(np.abs(det) > LEAST_AREA)
        has_slivers = len(wide) < len(det)
        if has_slivers:
            block = block.take(wide)
            source, output, S, O, det = (all_of.take(wide, axis=-1) for all_of in (source, output, S, O, det))
        J = np.stack([S[0] * O[1, 1] - S[1] * O[0, 1], S[1] * O[0, 0] - S[0] * O[1, 0]], axis=1) / det
        major, minor = _singular_values(J)
        starts = np.flatnonzero(np.diff(block, prepend=-1))
        moved_low, moved_high = output.min(axis=0), output.max(axis=0)
        return cls(
            source[0],
            source.min(axis=0),
            source.max(axis=0),
            output[0],
            moved_low,
            moved_high,
            J,
            major,
            np.maximum(minor, major / MOST_ANISOTROPY),
            has_slivers,
            np.append(starts, len(block)),
            np.minimum.reduceat(moved_low, starts, axis=1) if starts.size else moved_low,
            np.maximum.reduceat(moved_high, starts, axis=1) if starts.size else moved_high,
        )

    def read_for(self, box: Box, *, least_stretch: float) -> Read | None:
        """Return what drawing `box` reads, None where nothing is to be drawn."""
        first, last = np.array([[box[0] - 1], [box[1] - 1]]), np.array([[box[2]], [box[3]]])
        near = self._in_blocks(first, last)
        low = np.maximum(self.moved_low.take(near, axis=1), first)
        high = np.minimum(self.moved_high.take(near, axis=1), last)
        seen = np.flatnonzero((low[0] <= high[0]) & (low[1] <= high[1]))
        if len(seen) < len(near):
            near, low, high = near.take(seen), low.take(seen, axis=1), high.take(seen, axis=1)
        if not near.size:
            return Read((0, 0, 1, 1), 0, None, ()) if self.has_slivers else None
        # The image of a rectangle with centre c and half sides h has its centre at J c and half sides |J| h.
        J = self.jacobian.take(near, axis=2)
        middle, side = (low + high) / 2 - self.moved.take(near, axis=1), (high - low) / 2
        centre = self.rest.take(near, axis=1) + J[:, 0] * middle[0] + J[:, 1] * middle[1]
        half = np.abs(J[:, 0]) * side[0] + np.abs(J[:, 1]) * side[1]
        major, minor = self.major.take(near), self.minor.take(near)
        margin = 2 * np.maximum(major, 1.0) + 2
        left, top = (np.maximum(centre - half, self.rest_low.take(near, axis=1)) - margin).min(axis=1)
        right, bottom = (np.minimum(centre + half, self.rest_high.take(near, axis=1)) + margin).max(axis=1)
        finest, coarsest = (
            int(np.log2(max(float(s) / least_stretch, 1.0))) for s in (minor.min(), minor.max() * ROUNDING)
        )
        source = int(np.floor(left)), int(np.floor(top)), int(np.ceil(right)) + 1, int(np.ceil(bottom)) + 1
        return Read(source, finest, None if self.has_slivers else coarsest, self._filters_of(major))

    def _filters_of(self, major: Floats) -> Names:
        """Return what filter.glsl may count on for triangles with these values: one filter, short rows of texels."""
        most = np.inf if self.has_slivers else major.max()
        if most <= 1:
            return ("INTERPOLATED",)
        averaged = ("AVERAGED",) if major.min() > ROUNDING else ()
        return (*averaged, "NARROW") if SUPPORT * most * ROUNDING < NARROW_TEXELS else averaged

    def _in_blocks(self, first: Ints, last: Ints) -> Ints:
        """Return the triangles of all blocks that meet a rectangle of the output."""
        hit = np.flatnonzero(((self.low <= last) & (self.high >= first)).all(axis=0))
        begins, counts = self.starts[hit], self.starts[hit + 1] - self.starts[hit]
        before = np.cumsum(counts) - counts
        return np.asarray(np.arange(counts.sum()) + np.repeat(begins - before, counts))


def _triangles(nodes: Points) -> Floats:
    """Return the corners of both triangles of every quad: (3, 2, 2 M)."""
    x, y = np.moveaxis(nodes, -1, 0)
    quads = np.stack(
        [
            [side[rows, columns].ravel() for side in (x, y)]
            for rows in (np.s_[:-1], np.s_[1:])
            for columns in (np.s_[:-1], np.s_[1:])
        ]
    )
    a, b, d, c = quads
    return np.concatenate([np.stack([a, b, c]), np.stack([d, a, c])], axis=-1)


@lru_cache(maxsize=4)
def _blocks(shape: tuple[int, int], side: int) -> tuple[Ints, Ints]:
    """Return the numbers of the triangles of so many rows and columns of quads, block after block, and their blocks.

    First come the blocks (2 M,), then the numbers that `_triangles` gives what is in them.
    """
    row, column = (np.arange(size) // side for size in shape)
    number = np.tile((row[:, None] * (column[-1] + 1) + column).ravel(), 2)
    order = np.argsort(number, kind="stable")
    return number[order], order


def _singular_values(J: Floats) -> tuple[Floats, Floats]:
    """Return the greater and the lesser singular value: |J|^2 = s1^2 + s2^2 and |det J| = s1 s2."""
    squares = J[0, 0] ** 2 + J[0, 1] ** 2 + J[1, 0] ** 2 + J[1, 1] ** 2
    product = np.abs(J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0])
    major = np.sqrt(squares / 2 + np.sqrt(np.maximum(squares**2 / 4 - product**2, 0)))
    return major, product / np.maximum(major, 1e-12)
