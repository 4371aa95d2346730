"""How a grid with its outline held answers forces: the energy of `plate`, which sines make diagonal.

With d = 0 on the outline, the first differences of a row make up the matrix of the second difference with Dirichlet
ends, and its second differences make up the square of that; so do those of a column. So with L as in `dirichlet_grid`
the matrix of the energy and its inverse are

    A = L + ℓ² L²,      A⁻¹ = L⁻¹ - (L + ℓ⁻²)⁻¹.
"""

from dataclasses import dataclass

import numpy as np

from core.arrays import Floats, Points
from core.grid import Grid
from core.linalg.dirichlet_grid import DirichletGrid, LoadPlaces, Responses
from core.mapping.jacobians import Complexes


class HeldPlate:
    """Responses of a grid whose outline stays where it is, to forces at any places of the picture.

    Parameters
    ----------
    cell
        Width and height of a cell in units of their mean.
    rounded
        ℓ in cells.
    """

    def __init__(self, grid: Grid, *, cell: tuple[float, float], rounded: float) -> None:
        self._cell = grid.cell
        self._grid = DirichletGrid(*grid.shape, cell=cell)
        self._square = DirichletGrid(*grid.shape)
        self._shifts = 0.0, rounded**-2
        self._responses = [Responses(self._grid, shift=shift) for shift in self._shifts]

    def hold(self, points: Points) -> "HeldForces":
        """Return how it answers forces at the points (n, 2)."""
        places = (points + 0.5) / self._cell
        of_all, of_short_waves = (responses.between(places) for responses in self._responses)
        return HeldForces(np.asarray(of_all - of_short_waves), self._grid.loads_at(places), self)

    def spread(self, at: LoadPlaces, forces: Complexes) -> Complexes:
        """Return d (N,) for forces (n,)."""
        return _joined(self._grid.spread(at, _parts(forces), *self._shifts)).ravel()

    def solve_poisson(self, load: Complexes) -> Complexes:
        """Return y (R, C), 0 on the outline, with dᵀ w d y = `load` (R, C) inside, w = 1 for every quad."""
        # An inner edge belongs to two quads.
        return _joined(self._square.solve(_parts(load))) / 2


@dataclass(frozen=True, eq=False)
class HeldForces:
    """Answers to forces at some points."""

    S: Floats
    """What a force at one moves another (n, n)."""
    at: LoadPlaces
    plate: HeldPlate

    def answer(self, forces: Complexes) -> Complexes:
        """Return d (N,) for the forces (n,)."""
        return self.plate.spread(self.at, forces)


def _parts(z: Complexes) -> Floats:
    """Return x + iy as x and y (2, ...)."""
    return np.stack([z.real, z.imag])


def _joined(parts: Floats) -> Complexes:
    """Return x and y (2, ...) as x + iy."""
    z = np.empty(parts.shape[1:], np.complex128)
    z.real, z.imag = parts
    return z
