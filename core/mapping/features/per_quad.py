"""The method as FAT prints it: every quad of a feature turns by a rotation of its own  [FAT eqs. 2-4]."""

import numpy as np

from core.arrays import Ints
from core.grid import Grid
from core.linalg.laplacian import divergence, edge_weights
from core.mapping.features.quad_weights import Roles
from core.mapping.features.similarity import Bodies
from core.mapping.jacobians import Complexes, linear_parts


def load_per_quad(grid: Grid, w: Complexes, roles: Roles, owner: Ints, bodies: Bodies) -> Complexes:
    """Return Aᵀ b of FAT eq. 10 (R, C): what the edges of all quads ask for, W at the nodes being w (R, C).

    Quads that follow one of the features, its index the `owner` (R-1, C-1), ask for their rest edges turned by the
    rotation of W there, unless it stays upright, and scaled by its λ within its limits; all others ask for W's edges.
    """
    frames = linear_parts(grid, w)
    turns = np.append(bodies.turns, True)[owner]
    turn = np.where(owner >= 0, np.where(turns, frames.rotations, 1) * roles.weight**2, 0)
    sizes = roles.means(frames.smaller_singular_values.ravel()[roles.inside], roles.inside, bodies.count)
    turn *= bodies.clip_sizes(sizes, np.arange(bodies.count))[owner]
    width, height = grid.cell
    turn_across, turn_down = edge_weights(turn)
    follow_across, follow_down = edge_weights(np.where(owner >= 0, 0.0, 1.0))
    across = turn_across * width + follow_across * np.diff(w, axis=1)
    down = turn_down * (1j * height) + follow_down * np.diff(w, axis=0)
    return divergence(across, down)
