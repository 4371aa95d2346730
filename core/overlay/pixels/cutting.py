"""Cutting a thing out of the cloth along edges in the photo: the cheapest cut through a graph of the pixels."""

import maxflow
import numpy as np

from core.arrays import Bools, Floats
from core.overlay.smoothing import gaussian

BORDER = 0.5
"""What a pixel of the outline costs where the photo has no edge."""
EDGE, LEAST_BORDER = 4.0, 0.02
"""Squared difference of neighbours, over the usual one, at an edge, and what a pixel of the outline costs, over that
without an edge, at the sharpest one."""
BLUR_PX = 0.7
"""Blur of the photo in which edges are seen."""
STEPS = ((0, 1), (1, 0), (1, 1), (1, -1))
"""Rows and columns to neighbours, one of each two opposite ones."""
LEAST = 1e-3
"""What costs are whole multiples of: the search ends with exact sums only."""
MOST = 1e3
"""Cost of what must not be."""


def cut_out(photo: Floats, alike: Bools, thing: Floats, cloth: Floats) -> Bools:
    """Return the pixels (H, W) of a thing: the ones with which the pixels' costs and the outline's are least together.

    `thing` and `cloth` (H, W) are what a pixel costs as part of either, 0 to `MOST`; edges in the photo (H, W, 3) are
    measured over what neighbours usually differ by that are `alike` (H, W).
    """
    shape, soft = thing.shape, gaussian(photo, BLUR_PX)
    graph = maxflow.GraphFloat(thing.size, len(STEPS) * thing.size)
    nodes = graph.add_grid_nodes(shape)
    pairs = [pair(shape, *step) for step in STEPS]
    changes = [((soft[here] - soft[there]) ** 2).sum(-1) for here, there in pairs]
    inside = [change[alike[here] & alike[there]] for change, (here, there) in zip(changes[:2], pairs[:2], strict=True)]
    usual = EDGE * float(np.median(np.concatenate(inside))) if any(map(len, inside)) else 0.0
    for change, (here, there), (down, across) in zip(changes, pairs, STEPS, strict=True):
        length = float(np.hypot(down, across))
        kept = np.maximum(np.exp(-change / (2 * length**2 * max(usual, 1e-9))), LEAST_BORDER)
        cost = np.rint(BORDER / length * kept / LEAST)
        graph.add_edges(nodes[here].ravel(), nodes[there].ravel(), cost.ravel(), cost.ravel())
    graph.add_grid_tedges(nodes, *(np.rint(np.clip(cost, 0, MOST) / LEAST) for cost in (thing, cloth)))
    graph.maxflow()
    return np.asarray(graph.get_grid_segments(nodes), np.bool_)


def pair(shape: tuple[int, ...], down: int, across: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Return the parts of a picture of that shape (H, W) that lie so many rows and columns apart."""
    h, w = shape
    here = slice(0, h - down), slice(max(0, -across), w - max(0, across))
    there = slice(down, h), slice(max(0, across), w + min(0, across))
    return here, there
