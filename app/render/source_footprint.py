"""Which source pixels a part of the output reads, and by which filter."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from app.render.programs import Names
from app.render.sources.source import Box
from core.arrays import Floats, Ints, Points

MOST_ANISOTROPY = 16.0
"""As in mesh.vert."""
LEAST_AREA = 1e-3
"""Triangles of a smaller area, in square output pixels, hit no pixel worth the pixels they would read."""
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
    """The one filter of resample.frag that is needed, or none where it must choose."""


@dataclass(frozen=True, eq=False)
class SourceFootprint:
    """The triangles of a mesh, T of them, block after block, and the singular values of their d(source) / d(output)."""

    rest: Points
    """The first corner of each (T, 2), in source pixels."""
    rest_low: Points
    rest_high: Points
    """The box around each (T, 2)."""
    moved: Points
    """The same in output pixels."""
    moved_low: Points
    moved_high: Points
    jacobian: Floats
    """(T, 2, 2)"""
    major: Floats
    minor: Floats
    has_slivers: bool
    """Whether there are triangles besides these."""
    starts: Ints
    """The first triangle of each of B blocks, and T."""
    low: Points
    high: Points
    """The box around each block (B, 2), in output pixels."""

    @classmethod
    def of(cls, rest: Points, moved: Points) -> "SourceFootprint":
        """Return the reach of a grid (R, C, 2) in source and output pixels."""
        source, output = _triangles(rest), _triangles(moved)
        S, O = (np.stack([p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]], axis=-1) for p in (source, output))
        det = O[:, 0, 0] * O[:, 1, 1] - O[:, 0, 1] * O[:, 1, 0]
        block = _blocks((rest.shape[0] - 1, rest.shape[1] - 1))
        chosen = np.flatnonzero(np.abs(det) > LEAST_AREA)
        chosen = chosen[np.argsort(block[chosen], kind="stable")]
        source, output, S, O, det = source[chosen], output[chosen], S[chosen], O[chosen], det[chosen]
        adjugate = np.stack([O[:, 1, 1], -O[:, 0, 1], -O[:, 1, 0], O[:, 0, 0]], axis=-1).reshape(-1, 2, 2)
        J = S @ adjugate / det[:, None, None]
        major, minor = _singular_values(J)
        starts = np.flatnonzero(np.diff(block[chosen], prepend=-1))
        moved_low, moved_high = _box_of(output)
        return cls(
            source[:, 0],
            *_box_of(source),
            output[:, 0],
            moved_low,
            moved_high,
            J,
            major,
            np.maximum(minor, major / MOST_ANISOTROPY),
            len(chosen) < len(block),
            np.append(starts, len(chosen)),
            np.minimum.reduceat(moved_low, starts) if starts.size else moved_low,
            np.maximum.reduceat(moved_high, starts) if starts.size else moved_high,
        )

    def read_for(self, box: Box, *, least_stretch: float) -> Read | None:
        """Return what drawing `box` reads, None where nothing is to be drawn."""
        first, last = np.array([box[0] - 1, box[1] - 1]), np.array([box[2], box[3]])
        near = self._in_blocks(first, last)
        low, high = np.maximum(self.moved_low[near], first), np.minimum(self.moved_high[near], last)
        seen = (low <= high).all(axis=1)
        near, low, high = near[seen], low[seen], high[seen]
        if not near.size:
            return Read((0, 0, 1, 1), 0, None, ()) if self.has_slivers else None
        # The image of a rectangle with centre c and half sides h has its centre at J c and half sides |J| h.
        J = self.jacobian[near]
        middle = (low + high) / 2 - self.moved[near]
        centre = self.rest[near] + (J @ middle[..., None])[..., 0]
        half = (np.abs(J) @ (high - low)[..., None])[..., 0] / 2
        margin = 2 * np.maximum(self.major[near], 1.0)[:, None] + 2
        left, top = (np.maximum(centre - half, self.rest_low[near]) - margin).min(axis=0)
        right, bottom = (np.minimum(centre + half, self.rest_high[near]) + margin).max(axis=0)
        minor = self.minor[near]
        finest, coarsest = (
            int(np.log2(max(float(s) / least_stretch, 1.0))) for s in (minor.min(), minor.max() * ROUNDING)
        )
        source = int(np.floor(left)), int(np.floor(top)), int(np.ceil(right)) + 1, int(np.ceil(bottom)) + 1
        return Read(source, finest, None if self.has_slivers else coarsest, self._filters_of(near))

    def _filters_of(self, triangles: Ints) -> Names:
        """Return which of the two filters is the only one of some triangles; neither if both are."""
        major = self.major[triangles]
        if major.min() > ROUNDING:
            return ("AVERAGED",)
        return ("INTERPOLATED",) if major.max() <= 1 and not self.has_slivers else ()

    def _in_blocks(self, first: Points, last: Points) -> Ints:
        """Return the triangles of all blocks that meet a rectangle of the output."""
        hit = np.flatnonzero((self.low <= last).all(axis=1) & (self.high >= first).all(axis=1))
        begins, counts = self.starts[hit], self.starts[hit + 1] - self.starts[hit]
        before = np.cumsum(counts) - counts
        return np.asarray(np.arange(counts.sum()) + np.repeat(begins - before, counts))


def _triangles(nodes: Points) -> Points:
    """Return the corners of both triangles of every quad: (2 M, 3, 2)."""
    a, b, c, d = nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1]
    return np.stack([np.stack([a, b, c], axis=2), np.stack([d, a, c], axis=2)]).reshape(-1, 3, 2)


def _blocks(shape: tuple[int, int]) -> Ints:
    """Return the block of every triangle (2 M,) of so many rows and columns of quads."""
    row, column = (np.arange(size) // BLOCK for size in shape)
    number = row[:, None] * (column[-1] + 1) + column
    return np.tile(number.ravel(), 2)


def _box_of(triangles: Points) -> tuple[Points, Points]:
    """Return the least and the greatest position (T, 2) of the corners (T, 3, 2)."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def _singular_values(J: Floats) -> tuple[Floats, Floats]:
    """Return the greater and the lesser singular value: |J|^2 = s1^2 + s2^2 and |det J| = s1 s2."""
    squares = (J**2).sum(axis=(1, 2))
    product = np.abs(J[:, 0, 0] * J[:, 1, 1] - J[:, 0, 1] * J[:, 1, 0])
    major = np.sqrt(squares / 2 + np.sqrt(np.maximum(squares**2 / 4 - product**2, 0)))
    return major, product / np.maximum(major, 1e-12)
