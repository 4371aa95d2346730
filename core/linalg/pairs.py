"""Many systems of two equations at once."""

import numpy as np

from core.arrays import Points

_LEAST_AREA = 1e-18
"""A system with a smaller determinant has no solution."""


def solve_pairs(across: Points, down: Points, right: Points) -> Points:
    """Return the u (n, 2) with u_x across + u_y down = right, (n, 2) each; 0 where there is none."""
    area = across[:, 0] * down[:, 1] - across[:, 1] * down[:, 0]
    found = np.stack(
        [right[:, 0] * down[:, 1] - right[:, 1] * down[:, 0], across[:, 0] * right[:, 1] - across[:, 1] * right[:, 0]],
        axis=1,
    )
    usable = np.abs(area) > _LEAST_AREA
    return np.where(usable[:, None], found / np.where(usable, area, 1)[:, None], 0.0)
