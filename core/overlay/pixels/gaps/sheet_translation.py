"""Whole texels by which separate sheets of cloth are moved, so that the pattern goes on from one to the next.

Two sheets are compared where they are nearest to each other. Carried straight on, cloth is off by more the longer the
way, as its square, so a pair of places counts by the inverse of that squared. Those sheets that most lie beside each
other are joined first.
"""

import numpy as np

from core.arrays import Floats, Ints
from core.overlay.filters.distances import nearest_of

BESIDE = 0.25
"""Lattice steps up to which sheets are as near as can be."""
MISSED = 0.5
"""Lattice steps by which two sheets miss each other at most, as far as that counts."""


def find_translations(uv: Floats, sheet: Ints, slopes: Floats, basis: Floats, step_px: float) -> Floats:
    """Return the whole texels (n, 2) by which each of n sheets is moved.

    `sheet` (H, W) is the number of each pixel's, -1 for none, `uv` (H, W, 2) its coordinates, `slopes` (H, W, 2, 2)
    those of the place in the undeformed cloth around it, by row and column; `basis` (2, 2) is pixels of undeformed
    cloth a texel, `step_px` the side of a lattice step.
    """
    count = int(sheet.max()) + 1
    moved, group = np.zeros((count, 2)), np.arange(count)
    pairs = [beside(number, uv, sheet, slopes, basis, step_px) for number in range(count - 1)]
    if not pairs:
        return moved
    one, other, off, weight = (np.concatenate(column) for column in zip(*pairs, strict=True))
    while True:
        ends = np.sort(np.stack([group[one], group[other]], -1), 1)
        contact = np.zeros((count, count))
        np.add.at(contact, (ends[:, 0], ends[:, 1]), np.where(ends[:, 0] != ends[:, 1], weight, 0.0))
        if not contact.any():
            return moved
        low, high = np.unravel_index(contact.argmax(), contact.shape)
        mine = (ends == (low, high)).all(1)
        now = off[mine] + moved[other[mine]] - moved[one[mine]]
        now[group[one[mine]] == high] *= -1
        moved[group == high] -= usual_step(now, weight[mine], basis, step_px)
        group[group == high] = low


def beside(
    number: int, uv: Floats, sheet: Ints, slopes: Floats, basis: Floats, step_px: float
) -> tuple[Ints, Ints, Floats, Floats]:
    """Return pairs of places, one on the sheet of that number, the other on one of a higher number beside it.

    Returned are the numbers of both (n,), by how many texels (n, 2) the second one lies from where the first one leads,
    and weights (n,).
    """
    away, nearest = nearest_of(sheet == number)
    there = np.flatnonzero(sheet > number)
    here, owner, length = nearest.ravel()[there], sheet.ravel()[there], away.ravel()[there]
    # Of the places of a sheet that have the same one nearest, the nearest counts.
    order = np.lexsort((length, owner, here))
    first = np.diff(here[order], prepend=-1).astype(bool) | np.diff(owner[order], prepend=-1).astype(bool)
    chosen = order[first]
    here, there, owner, length = here[chosen], there[chosen], owner[chosen], length[chosen]
    way = np.stack(np.divmod(there, sheet.shape[1]), -1) - np.stack(np.divmod(here, sheet.shape[1]), -1)
    mean = (slopes.reshape(-1, 2, 2)[here] + slopes.reshape(-1, 2, 2)[there]) / 2
    led = np.einsum("nij,nj->ni", mean, way) @ np.linalg.inv(basis).T
    off = uv.reshape(-1, 2)[there] - uv.reshape(-1, 2)[here] - led
    return np.full(len(there), number), owner, off, np.maximum(length / step_px, BESIDE) ** -4.0


def usual_step(off: Floats, weight: Floats, basis: Floats, step_px: float) -> Floats:
    """Return the whole texels (2,) from which what is `off` (n, 2) is least far, by weight (n,)."""
    tried = np.unique(np.rint(off), axis=0)
    miss = np.linalg.norm((off - tried[:, None]) @ basis.T, axis=-1)
    return np.asarray(tried[(np.minimum(miss, MISSED * step_px) @ weight).argmin()], np.float64)
