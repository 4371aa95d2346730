"""Cutting a thing out of the cloth along edges in the photo: the cheapest cut through a graph of the pixels."""

import numpy as np

from core.arrays import Bools, Floats
from core.graphs.minimum_cut import LEAST_COST, minimum_cut
from core.overlay.filters.smoothing import gaussian
from core.overlay.neighbours import STEPS
from core.overlay.tolerances import SMOOTH_PX

BORDER = 0.5
"""What a pixel of the outline costs where the photo has no edge."""
EDGE, LEAST_BORDER = 4.0, 0.02
"""Squared difference of neighbours, over the usual one, at an edge, and what a pixel of the outline costs, over that
without an edge, at the sharpest one."""
EVIDENCE, SURELY = 0.05, 8.0
"""How much evidence at a pixel, the logarithm of a ratio of likelihoods, counts over a pixel of the outline where the
photo has no edge, and most that one pixel's evidence is."""
MOST = 1e3
"""What speaks for what must be."""


def cut_out(photo: Floats, alike: Bools, speaks: Floats) -> Bools:
    """Return the pixels (H, W) of a thing: those by which what `speaks` for it, less what the outline costs, is most.

    What `speaks` (H, W) is negative where a pixel is rather none of it, `MOST` at most either way; edges in the photo
    (H, W, 3) are measured over what neighbours usually differ by that are `alike` (H, W).
    """
    shape, soft = speaks.shape, gaussian(photo, SMOOTH_PX)
    nodes, costs = np.arange(speaks.size).reshape(shape), list[Floats]()
    pairs = [pair(shape, *step) for step in STEPS]
    changes = [((soft[here] - soft[there]) ** 2).sum(-1) for here, there in pairs]
    inside = [change[alike[here] & alike[there]] for change, (here, there) in zip(changes[:2], pairs[:2], strict=True)]
    usual = EDGE * float(np.median(np.concatenate(inside))) if any(map(len, inside)) else 0.0
    for change, (down, across) in zip(changes, STEPS, strict=True):
        length = float(np.hypot(down, across))
        kept = np.maximum(np.exp(-change / (2 * length**2 * max(usual, 1e-9))), LEAST_BORDER)
        costs.append(np.rint(BORDER / length * kept / LEAST_COST).ravel())
    one, other = (np.concatenate([nodes[pair[end]].ravel() for pair in pairs]) for end in (0, 1))
    against, in_favour = (np.rint(np.clip(part, 0, MOST) / LEAST_COST).ravel() for part in (-speaks, speaks))
    return minimum_cut(one, other, np.concatenate(costs), against, in_favour).reshape(shape)


def pair(shape: tuple[int, ...], down: int, across: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Return the parts of a picture of that shape (H, W) that lie so many rows and columns apart."""
    h, w = shape
    here = slice(0, h - down), slice(max(0, -across), w - max(0, across))
    there = slice(down, h), slice(max(0, across), w + min(0, across))
    return here, there
