"""Whether two lattices have led to the same cloth: one may have several of the other's texels, or shifted ones.

Right coordinates of one cloth are an affine map of one another, whatever their lattices are; those that lie wrong are
so each in its own way. Two lattices that lead to the same confirm one another.
"""

import cv2
import numpy as np

from core.arrays import Points
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.matched_keypoints import OFF
from core.overlay.registration.thin_plate import interpolation

LEAST_CELLS = 8
"""Cells of the mesh that two pieces have in common at least: an affine map takes any three anywhere."""


def agreement(one: tuple[FittedCloth, Fit], other: tuple[FittedCloth, Fit], times: float = 1.0) -> float:
    """Return over how much of the smaller one of two cloths of a photo both have the same coordinates.

    They are the same, piece by piece, but for an affine map. `times` is the size of the photo of the other one over
    that of the first.
    """
    (cloth, fit), (other_cloth, other_fit) = one, other
    off_px = OFF * min(cloth.side_px, other_cloth.side_px / times)
    rows, columns = np.indices(cloth.mesh.cells).reshape(2, -1)
    middles = cloth.mesh.cell * (np.stack([columns, rows], -1).astype(np.float64) + 0.5) - 0.5
    here, there = interpolation(cloth.mesh, middles), interpolation(other_cloth.mesh, times * (middles + 0.5) - 0.5)
    at = times * (middles + 0.5) // other_cloth.mesh.cell
    column, row = np.clip(at, 0, np.array(other_cloth.mesh.cells[::-1]) - 1).astype(int).T
    theirs = [piece.cells[row, column] for piece in other_fit.pieces]
    same = 0
    for piece in fit.pieces:
        for cells, other_piece in zip(theirs, other_fit.pieces, strict=True):
            both = piece.cells.ravel() & cells
            if both.sum() >= LEAST_CELLS:
                uv = there[both] @ other_piece.uv.reshape(-1, 2) @ other_cloth.basis.T
                same += count_mapped(uv, here[both] @ piece.uv.reshape(-1, 2) @ cloth.basis.T, off_px)
    return same / max(min(int(fit.cells.sum()), int(np.sum(theirs))), 1)


def count_mapped(source: Points, target: Points, off_px: float) -> int:
    """Return how many points (n, 2) one affine map takes to within so many pixels of their targets (n, 2) [RANSAC]."""
    _, mapped = cv2.estimateAffine2D(source, target, method=cv2.RANSAC, ransacReprojThreshold=off_px)
    return 0 if mapped is None else int(mapped.sum())
