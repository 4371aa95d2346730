"""Folded quads: those with a corner of non-positive signed area."""

import numpy as np

from core.arrays import Bools, Floats
from core.mapping.frames import Complexes


def corner_areas(z: Complexes) -> Floats:
    """Return the signed area spanned by the edges at every corner of every quad of z (R, C): (4, R-1, C-1).

    Corners run clockwise from the top left; an undeformed quad has four times its own area.
    """
    corners = np.stack([z[:-1, :-1], z[:-1, 1:], z[1:, 1:], z[1:, :-1]])
    ahead = np.roll(corners, -1, axis=0) - corners
    # What leads back from a corner is the reverse of what leads ahead from the one before it.
    behind = -np.roll(ahead, 1, axis=0)
    return ahead.real * behind.imag - ahead.imag * behind.real


def folded_quads(z: Complexes) -> Bools:
    """Return which quads (R-1, C-1) are folded."""
    return np.asarray((corner_areas(z) <= 0).any(axis=0), bool)
