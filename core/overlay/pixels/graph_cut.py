"""Cutting a thing out of the cloth along edges in the photo: the cheapest cut through a graph of the pixels."""

import numpy as np

from core.arrays import Bools, Floats, Singles
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


def cut_out(photo: Floats | Singles, alike: Bools, speaks: Floats) -> Bools:
    """Return the pixels (H, W) of a thing: those by which what `speaks` for it, less what the outline costs, is most.

    What `speaks` (H, W) is negative where a pixel is rather none of it, `MOST` either way where that is certain; edges
    in the photo (H, W, 3) are measured over what neighbours usually differ by that are `alike` (H, W).
    """
    is_open, thing = np.abs(speaks.ravel()) < MOST, speaks.ravel() > 0
    if not is_open.any():
        return thing.reshape(speaks.shape)
    shape, soft, costs = speaks.shape, gaussian(photo, SMOOTH_PX), list[Floats]()
    pairs = [pair(shape, *step) for step in STEPS]
    changes = [((soft[here] - soft[there]) ** 2).sum(-1) for here, there in pairs]
    inside = [change[alike[here] & alike[there]] for change, (here, there) in zip(changes[:2], pairs[:2], strict=True)]
    usual = EDGE * float(np.median(np.concatenate(inside))) if any(map(len, inside)) else 0.0
    for change, (down, across) in zip(changes, STEPS, strict=True):
        length = float(np.hypot(down, across))
        kept = np.maximum(np.exp(-change / (2 * length**2 * max(usual, 1e-9))), LEAST_BORDER)
        costs.append(np.rint(BORDER / length * kept / LEAST_COST).ravel())
    # Certain pixels are no nodes: one beside them that is not has what the outline costs there as its evidence.
    between, number = np.concatenate(costs), np.arange(speaks.size).reshape(shape)
    one, other = (np.concatenate([number[pair[end]].ravel() for pair in pairs]) for end in (0, 1))
    node = np.cumsum(is_open) - 1
    own = speaks.ravel()[is_open] / LEAST_COST
    for here, there in ((one, other), (other, one)):
        beside = is_open[here] & ~is_open[there]
        own += np.bincount(node[here[beside]], np.where(thing[there], between, -between)[beside], len(own))
    kept = is_open[one] & is_open[other]
    against, in_favour = (np.rint(np.maximum(part, 0)) for part in (-own, own))
    thing[is_open] = minimum_cut(node[one[kept]], node[other[kept]], between[kept], against, in_favour)
    return thing.reshape(shape)


def pair(shape: tuple[int, ...], down: int, across: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Return the parts of a picture of that shape (H, W) that lie so many rows and columns apart."""
    h, w = shape
    here = slice(0, h - down), slice(max(0, -across), w - max(0, across))
    there = slice(down, h), slice(max(0, across), w + min(0, across))
    return here, there
