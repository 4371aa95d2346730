"""Warps by the outline: four cubic Bezier sides, the inside follows  [Coons 1967].

With curves top(u), bottom(u) from left to right and left(v), right(v) from top to bottom that meet in the corners P,

    S(u, v) = (1-v) top(u) + v bottom(u) + (1-u) left(v) + u right(v)
              - ((1-u)(1-v) P00 + u (1-v) P10 + (1-u) v P01 + u v P11).

Straight sides with their handles at thirds give the bilinear map of the corners, and so the identity on the frame.
"""

from typing import NamedTuple

import numpy as np

from core.arrays import Floats, InputError, Points

RING = 12
"""Control points of an outline: corners at 0, 3, 6 and 9, clockwise from the top left, two handles after each."""


class _Sides(NamedTuple):
    """Values on the edge of a patch, as curves of u (top, bottom) and of v (left, right), and in its corners."""

    top: Points
    bottom: Points
    left: Points
    right: Points
    corners: Points
    """(4, 2), clockwise from the top left."""

    def at(self, u: Floats, v: Floats) -> Points:
        """Return S(u, v) for (..., 1) places."""
        ruled = (1 - v) * self.top + v * self.bottom + (1 - u) * self.left + u * self.right
        first, second, third, fourth = self.corners
        flat: Points = ruled - (1 - v) * ((1 - u) * first + u * second) - v * ((1 - u) * fourth + u * third)
        return flat


def follow_outline(base: Points, ring: Points) -> Points:
    """Return the grid `base` (R, C, 2), moved so that its edge lies on the outline `ring` (12, 2).

    The displacements of the edge's nodes spread over the inside as a Coons patch of them; of an undeformed grid that
    makes the Coons patch of the outline. Raises `InputError` for another number of points.
    """
    _check(ring)
    u, v = np.linspace(0, 1, base.shape[1]), np.linspace(0, 1, base.shape[0])
    goal = _curves(ring, u, v)
    moves = _Sides(
        (goal.top - base[0])[None],
        (goal.bottom - base[-1])[None],
        (goal.left - base[:, 0])[:, None],
        (goal.right - base[:, -1])[:, None],
        goal.corners - base[[0, 0, -1, -1], [0, -1, -1, 0]],
    )
    return base + moves.at(u[None, :, None], v[:, None, None])


def _check(ring: Points) -> None:
    if ring.shape != (RING, 2):
        raise InputError(f"outline: needs {RING} points, not an array of shape {ring.shape}")


def _curves(ring: Points, u: Floats, v: Floats) -> _Sides:
    """Return the sides' points at `u` across and `v` down."""
    top, right, bottom, left = (np.take(ring, range(k, k + 4), axis=0, mode="wrap") for k in (0, 3, 6, 9))
    return _Sides(_cubic(top, u), _cubic(bottom[::-1], u), _cubic(left[::-1], v), _cubic(right, v), ring[::3])


def _cubic(points: Points, t: Floats) -> Points:
    """Return the points (..., 2) of one cubic Bezier segment (4, 2) at `t` (...)."""
    weights = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3], axis=-1)
    found: Points = weights @ points
    return found
