"""The size that W leaves a feature  [FAT sec. 2.1]."""

import numpy as np

from core.arrays import Floats, Ints
from core.grid import Grid
from core.mapping.features.quad_weights import Roles
from core.mapping.jacobians import Complexes, Jacobians


def smaller_scales(grid: Grid, w: Complexes, roles: Roles, chosen: Ints) -> Floats:
    """Return λ (k,) of the `chosen` features (k,): the size that W leaves them in the direction that keeps least.

    The linear part of W in a feature is taken as a whole, as the feature moves: of a swirl, which shears every quad
    a different way, little is left.
    """
    count, (width, height) = int(chosen.max(initial=-1)) + 1, grid.cell
    quads = np.pad(roles.counts, (0, max(count - roles.counts.size, 0)))
    across, down = roles.sum_edges(w.ravel(), len(quads))
    each = 2 * np.maximum(quads, 1)
    t_x, t_y = (across / (each * width))[chosen], (1j * down / (each * height))[chosen]
    return Jacobians((t_x - t_y) / 2, (t_x + t_y) / 2).smaller_singular_values
