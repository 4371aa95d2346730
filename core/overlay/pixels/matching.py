"""Semi-global matching: of a few shifts the one at each place that agrees with those beside it (Hirschmüller 2008).

Minimised is, along paths from four sides that are added up,

    Σ C(x, s_x) + Σ (P1 where a shift is not the one beside it, but next to it).

No other shift may be beside one: P2 is infinite. Shifts are parts of a period: after the last one comes the first.
"""

import numpy as np

from core.arrays import Bools, Floats, Singles

NEXT = 0.6
"""P1."""


def sum_along_paths(costs: Singles, covered: Bools, cuts: tuple[Bools, Bools]) -> Singles:
    """Return the least costs (rows, columns, H, W) of paths to each place, one from every side, added up.

    A path begins anew where the cloth is not `covered` (H, W), and at the cuts from the place above and to the left.
    """
    total = np.zeros_like(costs)
    for axis, cut in enumerate(cuts):
        # What a step of the path reads and writes lies together in memory.
        own = np.ascontiguousarray(np.moveaxis(costs, axis + 2, 0))
        sums = np.zeros_like(own)
        inside, apart = (np.moveaxis(plane, axis, 0) for plane in (covered, cut))
        for order, edge in ((range(len(own)), 0), (range(len(own) - 1, -1, -1), 1)):
            path = np.zeros_like(own[0])
            for k in order:
                before = np.where(apart[min(k + edge, len(own) - 1)], 0.0, best_before(path))
                path = np.where(inside[k], own[k] + before, 0.0)
                sums[k] += path
        total += np.moveaxis(sums, 0, axis + 2)
    return total


def best_before(path: Singles) -> Singles:
    """Return what the cheapest shift (rows, columns, n) at the place before adds, over the least there."""
    near, least = np.full_like(path, np.inf), path.min((0, 1))
    for axis, count in enumerate(path.shape[:2]):
        for step in (1, -1):
            np.minimum(near, path.take((np.arange(count) + step) % count, axis), out=near)
    near += np.float32(NEXT)
    return np.asarray(np.minimum(path, near) - least, np.float32)


def best_shift(sums: Singles) -> Floats:
    """Return the shift (H, W, 2), texels, of the least sum (rows, columns, H, W), between the steps by a parabola."""
    rows, columns = sums.shape[:2]
    v, u = np.divmod(sums.reshape(rows * columns, *sums.shape[2:]).argmin(0), columns)
    y, x = np.indices(v.shape)
    here = sums[v, u, y, x]
    out = []
    for at, count, beside in (
        (u, columns, [sums[v, (u + k) % columns, y, x] for k in (-1, 1)]),
        (v, rows, [sums[(v + k) % rows, u, y, x] for k in (-1, 1)]),
    ):
        bend = np.maximum(beside[0] - 2 * here + beside[1], 1e-6)
        out.append((at + np.clip((beside[0] - beside[1]) / (2 * bend), -0.5, 0.5)) / count)
    return np.stack(out, -1)
