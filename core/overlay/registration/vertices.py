"""The lattice that coordinates imply: where they are whole numbers."""

import numpy as np

from core.arrays import Bools, Floats
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.mesh import ClothMesh, cross
from core.overlay.registration.registration import ClothState

TRIANGLES = ((0, 1, 3), (0, 3, 2))
"""Corners of a cell's two triangles, as in `Mesh.weights`."""


def vertices(mesh: ClothMesh, state: ClothState) -> Lattice:
    """Return the vertices of the lattice inside the cells in use, with the vectors that the mesh has there."""
    rows = mesh.corners[state.cells][:, TRIANGLES].reshape(-1, 3)
    uv, places = state.uv.reshape(-1, 2)[rows], mesh.positions().reshape(-1, 2)[rows]
    keys, points, hit = find_whole_coordinates(uv, places)
    sides, steps = (np.diff(corners[hit], axis=1).transpose(0, 2, 1) for corners in (places, uv))
    return Lattice(keys.astype(np.int64), PatchFrames(points, sides @ np.linalg.inv(steps), np.ones(len(keys))))


def find_whole_coordinates(uv: Floats, places: Floats) -> tuple[Floats, Floats, Bools]:
    """Return whole coordinates (n, 2) that triangles hold, their places (n, 2), and which triangles (m,) those are.

    `uv` and `places` (m, 3, 2) are of the corners. A triangle with an edge much shorter than a texel holds at most one
    vertex; two that share it both have it.
    """
    key = np.ceil(uv.min(1))
    right, down = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = cross(right, down)
    area[area == 0] = np.nan
    s, t = cross(key - uv[:, 0], down) / area, cross(right, key - uv[:, 0]) / area
    hit = (s >= 0) & (t >= 0) & (s + t <= 1)
    shares = np.stack([1 - s - t, s, t], -1)[hit]
    return key[hit], np.einsum("nk,nki->ni", shares, places[hit]), np.asarray(hit, np.bool_)
