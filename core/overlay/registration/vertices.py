"""The lattice that a registered mesh implies: where its coordinates are whole numbers."""

import numpy as np

from core.arrays import Floats
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.mesh import ClothMesh, cross
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.multivalued_lattice import lay_apart
from core.overlay.registration.region import misfit
from core.overlay.registration.registration import ClothState

TRIANGLES = ((0, 1, 3), (0, 3, 2))
"""Corners of a cell's two triangles, as in `Mesh.weights`."""


def vertices(mesh: ClothMesh, state: ClothState) -> Lattice:
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
        area[area == 0] = np.nan
        s = cross(key - uv[a], uv[c] - uv[a]) / area
        t = cross(uv[b] - uv[a], key - uv[a]) / area
        hit = (s >= 0) & (t >= 0) & (s + t <= 1)
        a, b, c, s, t = a[hit], b[hit], c[hit], s[hit, None], t[hit, None]
        keys.append(key[hit])
        points.append(places[a] + s * (places[b] - places[a]) + t * (places[c] - places[a]))
        edges = np.stack([places[b] - places[a], places[c] - places[a]], -1)
        bases.append(edges @ np.linalg.inv(np.stack([uv[b] - uv[a], uv[c] - uv[a]], -1)))
    whole = np.concatenate(keys).astype(np.int64)
    return Lattice(whole, PatchFrames(np.concatenate(points), np.concatenate(bases), np.ones(len(whole))))


def whole_lattice(cloth: FittedCloth, pieces: list[ClothState], fit: Fit) -> Lattice:
    """Return the vertices of all pieces, scored by how well the texture explains the quad to their lower right."""
    parts = [vertices(cloth.mesh, piece) for piece in pieces]
    scores = [confidence(cloth, piece, found, fit) for piece, found in zip(pieces, parts, strict=True)]
    frames = PatchFrames(
        np.concatenate([found.frames.points for found in parts]),
        np.concatenate([found.frames.bases for found in parts]),
        np.concatenate(scores),
    )
    return lay_apart(Lattice(np.concatenate([found.keys for found in parts]), frames))


def confidence(cloth: FittedCloth, piece: ClothState, found: Lattice, fit: Fit) -> Floats:
    """Return the share of the variance (K,) that is explained in the quad to the lower right of each vertex."""
    box = cloth.mesh.box_of(piece.cells, 1 + round(8 / cloth.mesh.cell))
    at = cloth.mesh.smooth_to_pixels(piece.values, box)
    modelled = at[..., 2:] * fit.texel(at[..., :2])
    bad, _ = misfit(cloth.photo[box], modelled, at[..., 2], cloth.valid[box], fit.tolerance, 2.0)
    inside = cloth.mesh.pixels_of(piece.cells)[box]
    quads = np.floor(at[inside, :2]).astype(np.int64)
    low = np.minimum(quads.min(0), found.keys.min(0)) if len(found) else quads.min(0)
    width = int(max(quads[:, 1].max(), found.keys[:, 1].max(initial=0)) - low[1] + 1)
    number = (quads[:, 0] - low[0]) * width + quads[:, 1] - low[1]
    keys = (found.keys[:, 0] - low[0]) * width + found.keys[:, 1] - low[1]
    count = int(max(number.max(), keys.max(initial=0))) + 1
    total, area = np.bincount(number, np.clip(1 - bad[inside], 0, 1), count), np.bincount(number, minlength=count)
    return np.asarray(total[keys] / np.maximum(area[keys], 1), np.float64)
