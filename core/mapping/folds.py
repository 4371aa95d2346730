"""Folded quads: those with a corner of non-positive signed area."""

from collections.abc import Iterator

import numpy as np

from core.arrays import Bools, Floats
from core.linalg.bands import cut_bands
from core.linalg.laplacian import steps
from core.mapping.jacobians import Complexes


def corner_areas(z: Complexes) -> Floats:
    """Return the signed area spanned by the edges at every corner of every quad of z (R, C): (4, R-1, C-1).

    Corners run clockwise from the top left; an undeformed quad has four times its own area.
    """
    rows, columns = z.shape
    found = np.zeros((4, rows - 1, columns))
    for corner, area in zip(found, _areas(z), strict=True):
        corner.ravel()[:-1] = area
    return found[..., :-1]


def find_folded_quads(z: Complexes) -> Bools:
    """Return which quads (R-1, C-1) are folded."""
    rows, columns = z.shape
    folded = np.zeros((rows - 1, columns), bool)
    for band in cut_bands(np.ones(rows - 1, bool), columns):
        each = folded[band].ravel()[:-1]
        for area in _areas(z[band.start : band.stop + 1]):
            each |= area <= 0
    return folded[:, :-1]


def _areas(z: Complexes) -> Iterator[Floats]:
    """Yield what `corner_areas` returns, a corner at a time, for quads row by row: two share the edges between them.

    Between two rows there is one more, of no meaning (`laplacian.steps`).
    """
    columns = z.shape[1]
    (across_x, down_x), (across_y, down_y) = (steps(part.ravel(), columns) for part in (z.real, z.imag))
    upper, lower, left, right = np.s_[:-columns], np.s_[columns:], np.s_[:-1], np.s_[1:]
    for row, column in ((upper, left), (upper, right), (lower, right), (lower, left)):
        area = across_x[row] * down_y[column]
        area -= across_y[row] * down_x[column]
        yield area
