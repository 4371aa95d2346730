"""How a grid with its outline held answers forces: the energy of `plate`, which sines make diagonal.

With d = 0 on the outline, the first differences of a row make up the matrix of the second difference with Dirichlet
ends, and its second differences make up the square of that; so do those of a column. So with L as in `dirichlet_grid`
the matrix of the energy and its inverse are

    A = L + ℓ² L²,      A⁻¹ = L⁻¹ - (L + ℓ⁻²)⁻¹.

What handles do is smooth over ℓ, a tenth of the picture: a grid finer than the default one has a plate on a grid of as
many nodes as that may have, refined by cubics.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from core.arrays import Floats, Ints, Points
from core.grid import DEFAULT_NODES_AT_MOST, Grid
from core.linalg.cubic_convolution import CubicConvolution, Smooth
from core.linalg.dirichlet_grid import DirichletGrid, LoadPlaces, Responses
from core.linalg.laplacian import edge_weights, laplacian
from core.mapping.jacobians import Complexes


class HeldPlate:
    """Responses of a grid whose outline stays where it is, to forces at any places of the picture.

    Parameters
    ----------
    smoothness
        ℓ as a share of the grid's diagonal.
    """

    def __init__(self, grid: Grid, *, smoothness: float) -> None:
        self._picture, most = grid, DEFAULT_NODES_AT_MOST
        self.grid = grid if grid.size <= most else grid.with_nodes(most)
        """What it is worked out on, of shape (r, c)."""
        self._cell = self.grid.cell
        self._grid = DirichletGrid(*self.grid.shape, cell=self.grid.cell_aspect)
        self._square = DirichletGrid(*self.grid.shape)
        self._shifts = 0.0, (smoothness * float(np.hypot(*self.grid.shape))) ** -2
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
        """Return y (r, c), 0 on the outline, with dᵀ w d y = `load` (r, c) inside, w = 1 for every quad."""
        return _solve_poisson(self._square, load)

    def sample(self, z: Complexes) -> Complexes:
        """Return what z at the picture's nodes (R, C) is at the plate's (r, c)."""
        if self.grid is self._picture:
            return z
        nodes, weights = self._places
        return np.asarray(np.einsum("nk,nk->n", weights, z.ravel()[nodes]).reshape(self.grid.shape))

    @cached_property
    def _places(self) -> tuple[Ints, Floats]:
        """Nodes of the picture around those of the plate, and their weights (r c, 4)."""
        return self._picture.weights_at(self.grid.nodes.reshape(-1, 2))

    def refine(self, d: Complexes, sides: Complexes | None) -> Smooth:
        """Return what d at the plate's nodes (r, c) is at the picture's (R, C), on the frame `sides` (R, C) or 0.

        What cubics miss of these is continued inwards by a membrane.
        """
        if self.grid is self._picture:
            return Smooth(d)
        if sides is None:
            return Smooth(d, self._cubic)
        missed = np.where(self._picture.outline, sides - self._cubic.refine(self.sample(sides)), 0)
        load = -laplacian(edge_weights(np.ones((self._picture.rows - 1, self._picture.columns - 1))), missed)
        return Smooth(self._cubic.refine(d) + missed + _solve_poisson(self._fine, load))

    @cached_property
    def _fine(self) -> DirichletGrid:
        return DirichletGrid(*self._picture.shape)

    @cached_property
    def _cubic(self) -> CubicConvolution:
        return CubicConvolution(self.grid.shape, self._picture.shape)


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


def _solve_poisson(square: DirichletGrid, load: Complexes) -> Complexes:
    # An inner edge belongs to two quads.
    return _joined(square.solve(_parts(load))) / 2


def _parts(z: Complexes) -> Floats:
    """Return x + iy as x and y (2, ...)."""
    return np.stack([z.real, z.imag])


def _joined(parts: Floats) -> Complexes:
    """Return x and y (2, ...) as x + iy."""
    z = np.empty(parts.shape[1:], np.complex128)
    z.real, z.imag = parts
    return z
