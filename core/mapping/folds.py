"""Folded quads: those with a corner of non-positive signed area."""

from collections.abc import Iterator

import numpy as np

from core.arrays import Bools, Floats
from core.mapping.jacobians import Complexes

_ROWS = 64
"""Rows of quads at a time: their edges stay in the processor's cache."""


def corner_areas(z: Complexes) -> Floats:
    """Return the signed area spanned by the edges at every corner of every quad of z (R, C): (4, R-1, C-1).

    Corners run clockwise from the top left; an undeformed quad has four times its own area.
    """
    return np.stack(list(_areas(z)))


def find_folded_quads(z: Complexes) -> Bools:
    """Return which quads (R-1, C-1) are folded."""
    folded = np.zeros((z.shape[0] - 1, z.shape[1] - 1), bool)
    for top in range(0, len(folded), _ROWS):
        for area in _areas(z[top : top + _ROWS + 1]):
            folded[top : top + _ROWS] |= area <= 0
    return folded


def _areas(z: Complexes) -> Iterator[Floats]:
    """Yield what `corner_areas` returns, a corner at a time: two quads share the edges between them."""
    x, y = np.ascontiguousarray(z.real), np.ascontiguousarray(z.imag)
    across_x, across_y = x[:, 1:] - x[:, :-1], y[:, 1:] - y[:, :-1]
    down_x, down_y = x[1:] - x[:-1], y[1:] - y[:-1]
    upper, lower, left, right = np.s_[:-1], np.s_[1:], np.s_[:, :-1], np.s_[:, 1:]
    for row, column in ((upper, left), (upper, right), (lower, right), (lower, left)):
        yield across_x[row] * down_y[column] - across_y[row] * down_x[column]
