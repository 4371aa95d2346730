"""A ring of cells around a grid, in which the outline fades out: the grid continued straight beyond its border."""

from functools import cache
from typing import NamedTuple

import numpy as np

from core.arrays import Ints, Points
from core.mapping.jacobians import Complexes

RING_PX = 1.5
"""How far the ring reaches, across the outline."""
MOST_RING_PX = 4.0
"""And at most, where cells meet the outline at a sharp angle."""


class RingNodes(NamedTuple):
    """Numbers of nodes in an array: of the ring along four sides (n,), and of those that it follows from."""

    beyond: Ints
    edge: Ints
    """The node at the border before each,"""
    inner: Ints
    """the one next to that,"""
    before: Ints
    after: Ints
    """and its neighbours along the border; at the ends of a side the node itself."""
    corners: Ints
    """Of the ring (4,);"""
    before_corners: Ints
    """the nodes before them,"""
    ends: Ints
    """and the two places in the arrays above that each lies beside (4, 2)."""


@cache
def ring_of(shape: tuple[int, int]) -> RingNodes:
    """Return the ring of an array of so many rows and columns, ring included."""
    numbers = np.arange(shape[0] * shape[1]).reshape(shape)
    sides = []
    for nodes in (numbers, numbers[::-1], numbers.T, numbers.T[::-1]):
        edge = nodes[1, 1:-1]
        before, after = np.append(edge[0], edge[:-1]), np.append(edge[1:], edge[-1])
        sides.append((nodes[0, 1:-1], edge, nodes[2, 1:-1], before, after))
    lengths = np.array([len(side[0]) for side in sides])
    last = lengths.cumsum() - 1
    first = last - lengths + 1
    ends = [(first[0], first[2]), (last[0], first[3]), (first[1], last[2]), (last[1], last[3])]
    corners, before_corners = numbers[[0, 0, -1, -1], [0, -1, 0, -1]], numbers[[1, 1, -2, -2], [1, -2, 1, -2]]
    beyond, edge, inner, before, after = (np.concatenate(parts) for parts in zip(*sides, strict=True))
    return RingNodes(beyond, edge, inner, before, after, corners, before_corners, np.array(ends))


def put_ring(moved: Points, *alike: Points) -> None:
    """Set the ring of the nodes `moved` (R + 2, C + 2, 2), in output pixels, from those inside it; and that of others.

    A node of the ring lies beyond the border's by a share of the last step towards it, the same share in every array.
    """
    ring, z = ring_of(moved.shape[:2]), _flat(moved)
    step, along = z[ring.edge] - z[ring.inner], z[ring.after] - z[ring.before]
    across = np.abs((step.conj() * along).imag) / np.maximum(np.abs(along), 1e-6)
    reach = np.minimum(RING_PX / np.maximum(across, 1e-6), MOST_RING_PX / np.maximum(np.abs(step), 1e-6))
    for nodes in (moved, *alike):
        z = _flat(nodes)
        edge = z[ring.edge]
        step = reach * (edge - z[ring.inner])
        z[ring.beyond] = edge + step
        z[ring.corners] = z[ring.before_corners] + step[ring.ends].sum(axis=1)


def _flat(nodes: Points) -> Complexes:
    """View nodes (R, C, 2) as x + iy (R C,)."""
    return nodes.view(np.complex128).reshape(-1, copy=False)
