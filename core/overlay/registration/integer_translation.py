"""Whole texels between the coordinates of separate pieces of cloth, so that a pattern goes on from piece to piece."""

from dataclasses import replace

import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints, Points
from core.overlay.mesh import ClothMesh
from core.overlay.registration.registration import ClothState

GAP = 2
"""Texels between the coordinates of two pieces: vertices that are next to each other are of one piece."""
FURTHEST = 12
"""Texels by which a piece may be moved from where the others lead, before it is put beyond all of them."""


def in_phase(mesh: ClothMesh, pieces: tuple[ClothState, ...], step_px: float) -> list[ClothState]:
    """Return the pieces with their coordinates moved by whole texels: as the pieces before lead, but none too near."""
    moved: list[ClothState] = []
    taken = np.empty((0, 2), np.int64)
    for piece in pieces:
        keys = quads(mesh, piece)
        if moved:
            shift = free_shift(keys, taken, leading(mesh, moved, piece, step_px))
            piece, keys = replace(piece, uv=piece.uv + shift), keys + shift
        moved.append(piece)
        taken = np.concatenate([taken, keys])
    return moved


def quads(mesh: ClothMesh, piece: ClothState) -> Ints:
    """Return the texels (n, 2) that a piece has nodes in."""
    return np.unique(np.floor(piece.uv[mesh.nodes_of(piece.cells)]).astype(np.int64), axis=0)


def leading(mesh: ClothMesh, others: list[ClothState], piece: ClothState, step_px: float) -> Ints:
    """Return the texels (2,) from a piece's coordinates to those that the nearest of the others has, carried on."""
    places, mine = mesh.positions(), mesh.nodes_of(piece.cells)
    tree = scipy.spatial.cKDTree(places[mine])
    ends = [closest(places[mesh.nodes_of(other.cells)], places[mine], tree) for other in others]
    number = min(range(len(others)), key=lambda k: float(np.linalg.norm(ends[k][1] - ends[k][0])))
    other, (theirs, ours) = others[number], ends[number]
    middle = (theirs + ours) / 2
    there = carry(places, other.uv, mesh.nodes_of(other.cells), theirs, middle, 2 * step_px)
    here = carry(places, piece.uv, mine, ours, middle, 2 * step_px)
    return np.rint(there - here).astype(np.int64)


def closest(points: Points, others: Points, tree: "scipy.spatial.cKDTree") -> tuple[Points, Points]:
    """Return the point (2,) nearest to any of `others`, which the tree holds, and that one."""
    distances, rows = (np.asarray(a) for a in tree.query(points))
    first = int(distances.argmin())
    return points[first], others[int(rows[first])]


def carry(places: Floats, uv: Floats, used: Bools, near: Points, to: Points, reach_px: float) -> Points:
    """Return the coordinates (2,) at `to` of the affine map that is closest to the used nodes around `near`."""
    close = used & (np.linalg.norm(places - near, axis=-1) < reach_px)
    offsets = np.concatenate([places[close] - to, np.ones((int(close.sum()), 1))], -1)
    return np.asarray(np.linalg.lstsq(offsets, uv[close], rcond=None)[0][2], np.float64)


def free_shift(keys: Ints, taken: Ints, wanted: Ints, *, gap: int = GAP) -> Ints:
    """Return the shift (2,) nearest to `wanted` that leaves a `gap` between texels (n, 2) and those taken."""
    t = np.arange(-FURTHEST, FURTHEST + 1)
    around = np.stack(np.meshgrid(t, t), -1).reshape(-1, 2)
    tree = scipy.spatial.cKDTree(taken)
    for offset in around[np.argsort(np.linalg.norm(around, axis=1), kind="stable")]:
        distance, _ = tree.query(keys + wanted + offset, p=np.inf, distance_upper_bound=gap + 0.5)
        if not np.isfinite(distance).any():
            return np.asarray(wanted + offset, np.int64)
    return np.array([taken[:, 0].max() + 1 + gap - keys[:, 0].min(), wanted[1]])
