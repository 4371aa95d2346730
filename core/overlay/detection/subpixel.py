"""Where between pixels a surface is highest: the vertex of the paraboloid that fits a maximum and its neighbours."""

import numpy as np

from core.arrays import Points, Singles

NEAR = np.array([(i, j) for j in (-1, 0, 1) for i in (-1, 0, 1)])
"""Columns and rows (9, 2) from a pixel to its neighbours, and to itself."""
PARABOLOID = np.linalg.pinv(np.stack([*(NEAR**2).T, NEAR.prod(1), *NEAR.T, np.ones(9)], -1).astype(float))
"""The coefficients (6, 9) of x**2, y**2, x y, x, y and 1 that fit nine values by least squares."""


def find_vertices(values: Singles) -> Points:
    """Return where (n, 2), in pixels from the middle one, is the vertex of what fits each 3 x 3 `values` (n, 9).

    That is 0 where a value is not finite, and where the paraboloid has no maximum within a pixel.
    """
    xx, yy, xy, along_x, along_y, _ = PARABOLOID @ values.T
    bend = 4 * xx * yy - xy**2
    with np.errstate(invalid="ignore", divide="ignore"):
        vertices = np.stack([xy * along_y - 2 * yy * along_x, xy * along_x - 2 * xx * along_y], -1) / bend[:, None]
        is_maximum = (xx < 0) & (bend > 0) & (np.abs(vertices) <= 1).all(1)
    return np.where(is_maximum[:, None], vertices, 0.0)
