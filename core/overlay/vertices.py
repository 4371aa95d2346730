"""The lattice that a registered mesh implies: where its coordinates are whole numbers."""

import numpy as np

from core.overlay.alignment import Frames
from core.overlay.lattice import Lattice
from core.overlay.mesh import Mesh, cross
from core.overlay.registration import State

TRIANGLES = ((0, 1, 3), (0, 3, 2))
"""Corners of a cell's two triangles, as in `Mesh.weights`."""


def vertices(mesh: Mesh, state: State) -> Lattice:
    """Return the vertices of the lattice inside the cells in use, with the vectors that the mesh has there.

    A triangle with an edge much shorter than a texel holds at most one vertex; two that share it both have it.
    """
    corners = mesh.corners[state.cells]
    uv, places = state.uv.reshape(-1, 2), mesh.positions().reshape(-1, 2)
    keys, points, bases = [], [], []
    for triangle in TRIANGLES:
        a, b, c = (corners[:, k] for k in triangle)
        key = np.ceil(np.min([uv[a], uv[b], uv[c]], axis=0))
        area = cross(uv[b] - uv[a], uv[c] - uv[a])
        s = cross(key - uv[a], uv[c] - uv[a]) / area
        t = cross(uv[b] - uv[a], key - uv[a]) / area
        hit = (s >= 0) & (t >= 0) & (s + t <= 1)
        a, b, c, s, t = a[hit], b[hit], c[hit], s[hit, None], t[hit, None]
        keys.append(key[hit])
        points.append(places[a] + s * (places[b] - places[a]) + t * (places[c] - places[a]))
        edges = np.stack([places[b] - places[a], places[c] - places[a]], -1)
        bases.append(edges @ np.linalg.inv(np.stack([uv[b] - uv[a], uv[c] - uv[a]], -1)))
    whole = np.concatenate(keys).astype(np.int64)
    return Lattice(whole, Frames(np.concatenate(points), np.concatenate(bases), np.ones(len(whole))))
