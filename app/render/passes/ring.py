"""A ring of cells around a grid, in which the outline fades out: the grid continued straight beyond its border."""

import numpy as np

from core.arrays import Floats, Points

RING_PX = 1.5
"""How far the ring reaches, across the outline."""
MOST_RING_PX = 4.0
"""And at most, where cells meet the outline at a sharp angle."""


def put_ring(moved: Points, *alike: Points) -> None:
    """Set the ring of the nodes `moved` (R + 2, C + 2, 2), in output pixels, from those inside it; and that of others.

    A node of the ring lies beyond the border's by a share of the last step towards it, the same share in every array.
    """
    inner = moved[1:-1, 1:-1]
    top, bottom = _reach(inner[0], inner[1]), _reach(inner[-1], inner[-2])
    left, right = _reach(inner[:, 0], inner[:, 1]), _reach(inner[:, -1], inner[:, -2])
    for ring in (moved, *alike):
        nodes = ring[1:-1, 1:-1]
        ring[0], ring[-1] = _continue_on(nodes[0]), _continue_on(nodes[-1])
        ring[:, 0], ring[:, -1] = _continue_on(nodes[:, 0]), _continue_on(nodes[:, -1])
        ring[0] += _steps(top, nodes[0] - nodes[1])
        ring[-1] += _steps(bottom, nodes[-1] - nodes[-2])
        ring[:, 0] += _steps(left, nodes[:, 0] - nodes[:, 1])
        ring[:, -1] += _steps(right, nodes[:, -1] - nodes[:, -2])


def _reach(edge: Points, inner: Points) -> Floats:
    """Return how many steps between nodes (n, 2) the ring reaches beyond each of `edge`: (n,)."""
    step = inner - edge
    tangent = np.concatenate([edge[1:], edge[-1:]]) - np.concatenate([edge[:1], edge[:-1]])
    area = np.abs(step[:, 0] * tangent[:, 1] - step[:, 1] * tangent[:, 0])
    across = area / np.maximum(np.hypot(*tangent.T), 1e-6)
    length = np.hypot(*step.T)
    reach: Floats = np.minimum(RING_PX / np.maximum(across, 1e-6), MOST_RING_PX / np.maximum(length, 1e-6))
    return reach


def _steps(reach: Floats, step: Points) -> Points:
    """Return the way from the nodes of one side of the border, and of the corners beyond its ends, to the ring."""
    return _continue_on(reach[:, None] * step)


def _continue_on(nodes: Points) -> Points:
    """Return the array with its first and its last element once more."""
    return np.concatenate([nodes[:1], nodes, nodes[-1:]])
