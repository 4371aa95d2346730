"""Texture coordinates all over the mesh from the lattice's vertices: a thin-plate spline, solved on the grid.

Minimises Σ_k w |uv(p_k) - k|² + Σ_k w' |∇uv(p_k) - A_k⁻¹|² + λ |second differences of uv|². The frames' inverses are
the derivatives, so a vertex counts three times; beyond the lattice the plate goes on straight.
"""

import numpy as np
import scipy

from core.arrays import Bools, Floats, Points
from core.linalg.factor import Factor
from core.overlay.detection.lattice import Lattice
from core.overlay.mesh import ClothMesh

REACH = 2.0
"""Longest lattice vectors beyond the outermost vertices to which coordinates are spread."""


def spread(mesh: ClothMesh, lattice: Lattice, *, stiffness: float = 1e-3) -> Floats:
    """Return texture coordinates (R, C, 2) at the nodes of the mesh, NaN far from the lattice."""
    points, keys = lattice.frames.points, lattice.keys.astype(float)
    inverse = np.linalg.inv(lattice.frames.bases)
    rows, targets = [interpolation(mesh, points)], [keys]
    for axis in (0, 1):
        # A quarter of a texel to both sides of a vertex along each of its vectors.
        offset = lattice.frames.bases[:, :, axis] / 4
        for sign in (1, -1):
            rows.append(0.5 * interpolation(mesh, points + sign * offset))
            targets.append(0.5 * (keys + sign * np.einsum("kij,kj->ki", inverse, offset)))
    reach = REACH * float(np.linalg.norm(lattice.frames.bases, axis=1).max())
    used = nodes_between(mesh, points.min(0) - reach, points.max(0) + reach)
    return solve_plate(
        mesh, used, scipy.sparse.csr_array(scipy.sparse.vstack(rows)), np.concatenate(targets), stiffness
    )


def nodes_between(mesh: ClothMesh, low: Points, high: Points) -> Bools:
    """Return which nodes (R, C) lie in the box from `low` to `high` (2,), pixels."""
    places = mesh.positions()
    return np.asarray(((places >= low) & (places <= high)).all(-1), np.bool_)


def solve_plate(
    mesh: ClothMesh, used: Bools, rows: "scipy.sparse.csr_array", targets: Floats, stiffness: float
) -> Floats:
    """Return values (R, C, k) at the nodes in use that meet rows @ values = targets (n, k) and bend little."""
    L, rows = (matrix[:, used.ravel()] for matrix in (mesh.bending(used), rows))
    A = rows.T @ rows + stiffness * (L.T @ L)
    A = A + 1e-9 * scipy.sparse.eye_array(A.shape[0])
    values = np.full((*mesh.nodes, targets.shape[1]), np.nan)
    values[used] = Factor(A).solve(rows.T @ targets)
    return values


def interpolation(mesh: ClothMesh, points: Points) -> "scipy.sparse.csr_array":
    """Return the matrix that takes node values to places (n, 2), bilinear, zero rows for places off the mesh."""
    at = (points + 0.5) / mesh.cell
    first = np.floor(at).astype(np.int64)
    inside: Bools = np.asarray(((first >= 0) & (first < np.array(mesh.cells[::-1]))).all(1), np.bool_)
    x, y = (at - first).T
    column, row = np.clip(first, 0, np.array(mesh.cells[::-1]) - 1).T
    numbers = mesh.corners[row, column]
    weights = np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y], -1) * inside[:, None]
    count = np.repeat(np.arange(len(points)), 4)
    return scipy.sparse.csr_array(
        (weights.ravel(), (count, numbers.ravel())), shape=(len(points), mesh.corners.max() + 1)
    )
