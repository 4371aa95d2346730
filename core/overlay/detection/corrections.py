"""Lattices from what a user says: corrected vertices, or one texel marked."""

import numpy as np

from core.arrays import Floats, InputError, Ints, Points
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.basis import canonical
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import Lattice, neighbour_rows, parts

LEAST_VERTICES = 3
"""Fewer lie in one line, or are alike by chance."""
LEAST_AREA_PX = 4.0
"""Area of the usual texel of a corrected lattice, px^2."""


def lattices_of(keys: Ints, points: Points) -> list[Lattice]:
    """Return the connected lattices of vertices with integer coordinates (n, 2) at `points` (n, 2), largest first.

    Vertices without a neighbour are left out. Raises `InputError` if a vertex comes twice, if no part has steps in
    both directions, or if the usual texel is no area to speak of.
    """
    if len(np.unique(keys, axis=0)) < len(keys):
        raise InputError("lattice: a vertex comes twice")
    near = neighbour_rows(keys)
    whole = Lattice(keys, PatchFrames(points, vectors(points, near), np.ones(len(keys))))
    found = [whole[rows] for rows in parts(near) if len(rows) >= LEAST_VERTICES and spans(keys[rows])]
    if not found:
        raise InputError("lattice: needs vertices that are next to each other in both directions")
    wide = [part for part in found if abs(np.linalg.det(np.median(part.frames.bases, axis=0))) > LEAST_AREA_PX]
    if not wide:
        raise InputError("lattice: its vertices lie on one spot or in one line of the picture")
    return sorted(wide, key=len, reverse=True)


def spans(keys: Ints) -> bool:
    """Return whether coordinates (n, 2) do not lie in one line."""
    return int(np.linalg.matrix_rank(keys - keys[0])) == 2


def vectors(points: Points, near: Ints) -> Floats:
    """Return the lattice vectors (n, 2, 2) at vertices: means of the steps to neighbours, else the usual vector."""
    steps = np.where((near >= 0)[..., None], points[near] - points[:, None], np.nan)
    bases = np.empty((len(points), 2, 2))
    for axis in (0, 1):
        # Neighbours are right, below, left, above: both steps of an axis point the same way after a change of sign.
        both = np.stack([steps[:, axis], -steps[:, axis + 2]], 1)
        known = np.isfinite(both[..., 0])
        mean = np.where(known[..., None], both, 0).sum(1) / np.maximum(known.sum(1), 1)[:, None]
        usual = np.median(mean[known.any(1)], axis=0) if known.any() else np.zeros(2)
        bases[:, :, axis] = np.where(known.any(1)[:, None], mean, usual)
    return bases


def texel_between(corner: Points, opposite: Points) -> Proposal:
    """Return the proposal of an upright texel with two opposite corners (2,), as a user marks one."""
    width, height = np.abs(np.asarray(opposite, float) - np.asarray(corner, float))
    if min(width, height) < 2:
        raise InputError("texel: its corners are too close together")
    return Proposal((np.asarray(corner, float) + opposite) / 2, canonical(np.diag([width, height])), 1.0)
