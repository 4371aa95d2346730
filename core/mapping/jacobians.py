"""The linear part of a mapping on every quad, and what it does to shapes  [FAT eq. 1-2].

In the plane a linear map is a pair of complex numbers, u -> a u + b conj(u): a is its similarity part, b its anti-
conformal part. Then |a| + |b| and ||a| - |b|| are its singular values, |a|² - |b|² its determinant, and a / |a| the
proper rotation closest to it, the polar factor of FAT eq. 2 without reflections.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.arrays import Floats, Points
from core.grid import Grid

Complexes = NDArray[np.complex128]
"""Positions or edge vectors as x + iy."""


def as_complex(points: Points) -> Complexes:
    """View positions (..., 2) as x + iy (...)."""
    return np.ascontiguousarray(points, np.float64).view(np.complex128)[..., 0]


def as_positions(z: Complexes) -> Points:
    """View x + iy (...) as positions (..., 2)."""
    return np.ascontiguousarray(z)[..., None].view(np.float64)


@dataclass(frozen=True)
class Jacobians:
    """Linear parts (R-1, C-1) of a mapping: u -> `similar` u + `opposite` conj(u)."""

    similar: Complexes
    opposite: Complexes

    @property
    def rotations(self) -> Complexes:
        """The closest proper rotations, as unit complex numbers (FAT eq. 2); 1 where every rotation is as close."""
        length = np.abs(self.similar)
        return np.divide(self.similar, length, out=np.ones_like(self.similar), where=length > 0)

    @property
    def smaller_singular_values(self) -> Floats:
        """What each quad keeps of its size in the direction that keeps least."""
        values: Floats = np.abs(np.abs(self.similar) - np.abs(self.opposite))
        return values


def linear_parts(grid: Grid, z: Complexes) -> Jacobians:
    """Fit a linear map to every quad (R-1, C-1) of the grid mapped to z (R, C)."""
    return corner_frames(grid, (z[:-1, :-1], z[:-1, 1:], z[1:, 1:], z[1:, :-1]))


def corner_frames(grid: Grid, corners: tuple[Complexes, Complexes, Complexes, Complexes]) -> Jacobians:
    """Fit a linear map to every quad of the grid by where its corners end, clockwise from the top left.

    Rest quads are w x h rectangles, so that U Uᵀ = diag(w², h²) and T = U' U* of FAT eq. 1 has for its columns the
    means of the two edges across, over w, and of the two edges down, over h.
    """
    width, height = grid.cell
    one, two, three, four = corners
    t_x = ((two - one) + (three - four)) / (2 * width)
    t_y = 1j * (((four - one) + (three - two)) / (2 * height))
    return Jacobians((t_x - t_y) / 2, (t_x + t_y) / 2)
