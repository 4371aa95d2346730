"""Which source pixels a part of the output reads: only large pictures, drawn window by window, need to know."""

from dataclasses import dataclass

import numpy as np

from app.render.sources.source import Box
from core.arrays import Floats, Points

MOST_ANISOTROPY = 16.0
"""As in mesh.vert."""
LEAST_AREA = 1e-3
"""Triangles of a smaller area, in square output pixels, hit no pixel worth the pixels they would read."""


@dataclass(frozen=True, eq=False)
class Reach:
    """The triangles of a mesh: T of them, corners (T, 3, 2), and the singular values of their d(source) / d(output)."""

    rest: Points
    moved: Points
    jacobian: Floats
    """(T, 2, 2)"""
    major: Floats
    minor: Floats

    @classmethod
    def of(cls, rest: Points, moved: Points) -> "Reach":
        """Return the reach of a grid (R, C, 2) in source and output pixels."""
        source, output = _triangles(rest), _triangles(moved)
        S, O = (np.stack([p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]], axis=-1) for p in (source, output))
        det = O[:, 0, 0] * O[:, 1, 1] - O[:, 0, 1] * O[:, 1, 0]
        usable = np.abs(det) > LEAST_AREA
        source, output, S, O, det = source[usable], output[usable], S[usable], O[usable], det[usable]
        adjugate = np.stack([O[:, 1, 1], -O[:, 0, 1], -O[:, 1, 0], O[:, 0, 0]], axis=-1).reshape(-1, 2, 2)
        J = S @ adjugate / det[:, None, None]
        major, minor = _singular_values(J)
        return cls(source, output, J, major, np.maximum(minor, major / MOST_ANISOTROPY))

    def read_for(self, box: Box, *, least_stretch: float) -> tuple[Box, int]:
        """Return the source pixels that drawing `box` reads, and the finest level of the pyramid among them."""
        low = np.maximum(self.moved.min(axis=1), [box[0] - 1, box[1] - 1])
        high = np.minimum(self.moved.max(axis=1), [box[2], box[3]])
        seen = (low <= high).all(axis=1)
        if not seen.any():
            return (0, 0, 1, 1), 0
        # The image of a rectangle with centre c and half sides h has its centre at J c and half sides |J| h.
        J = self.jacobian[seen]
        middle = (low[seen] + high[seen]) / 2 - self.moved[seen, 0]
        centre = self.rest[seen, 0] + (J @ middle[..., None])[..., 0]
        half = (np.abs(J) @ (high[seen] - low[seen])[..., None])[..., 0] / 2
        margin = 2 * np.maximum(self.major[seen], 1.0)[:, None] + 2
        left, top = (np.maximum(centre - half, self.rest[seen].min(axis=1)) - margin).min(axis=0)
        right, bottom = (np.minimum(centre + half, self.rest[seen].max(axis=1)) + margin).max(axis=0)
        level = int(np.floor(np.log2(max(float(self.minor[seen].min()) / least_stretch, 1.0))))
        return (int(np.floor(left)), int(np.floor(top)), int(np.ceil(right)) + 1, int(np.ceil(bottom)) + 1), level


def _triangles(nodes: Points) -> Points:
    """Return the corners of both triangles of every quad: (2 M, 3, 2)."""
    a, b, c, d = nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1]
    return np.stack([np.stack([a, b, c], axis=2), np.stack([d, a, c], axis=2)]).reshape(-1, 3, 2)


def _singular_values(J: Floats) -> tuple[Floats, Floats]:
    """Return the greater and the lesser singular value: |J|^2 = s1^2 + s2^2 and |det J| = s1 s2."""
    squares = (J**2).sum(axis=(1, 2))
    product = np.abs(J[:, 0, 0] * J[:, 1, 1] - J[:, 0, 1] * J[:, 1, 0])
    major = np.sqrt(squares / 2 + np.sqrt(np.maximum(squares**2 / 4 - product**2, 0)))
    return major, product / np.maximum(major, 1e-12)
