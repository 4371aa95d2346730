"""The method as FAT prints it: every quad of a feature turns by a rotation of its own  [FAT eqs. 2-4]."""

import numpy as np

from core.arrays import Ints
from core.grid import Grid
from core.linalg.laplacian import divergence, edge_weights
from core.mapping.features.quad_weights import Roles
from core.mapping.jacobians import Complexes, linear_parts


def load_per_quad(grid: Grid, w: Complexes, roles: Roles, owner: Ints, count: int, *, keeps_size: bool) -> Complexes:
    """Return Aᵀ b of FAT eq. 10 (R, C): what the edges of all quads ask for, W at the nodes being w (R, C).

    Quads that follow one of `count` features, its index the `owner` (R-1, C-1), ask for their rest edges turned by the
    rotation of W there and, unless it `keeps_size`, scaled by the feature's λ; all others (-1) ask for W's edges.
    """
    frames = linear_parts(grid, w)
    turn = np.where(owner >= 0, frames.rotations * roles.weight**2, 0)
    if not keeps_size:
        sizes = frames.smaller_singular_values.ravel()[roles.inside]
        turn *= roles.means(sizes, roles.inside, count)[owner]
    width, height = grid.cell
    turn_across, turn_down = edge_weights(turn)
    follow_across, follow_down = edge_weights(np.where(owner >= 0, 0.0, 1.0))
    across = turn_across * width + follow_across * np.diff(w, axis=1)
    down = turn_down * (1j * height) + follow_down * np.diff(w, axis=0)
    return divergence(across, down)
