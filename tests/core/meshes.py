"""What tests ask of meshes beside what the program asks."""

import numpy as np

from core.arrays import Floats, Points
from core.mesh import Mesh


def jacobians_of(mesh: Mesh, points: Points) -> Floats:
    """Return d canvas / d image (n, 2, 2) at picture positions (n, 2), columns for x and y."""
    nodes, weights = mesh.grid.weights_at(points)
    v, u = weights[:, 2] + weights[:, 3], weights[:, 1] + weights[:, 2]
    A, B, C, D = mesh.warped.reshape(-1, 2)[nodes].transpose(1, 0, 2)
    across = (1 - v)[:, None] * (B - A) + v[:, None] * (C - D)
    down = (1 - u)[:, None] * (D - A) + u[:, None] * (C - B)
    width, height = mesh.grid.cell
    return np.stack([across / width, down / height], axis=-1)
