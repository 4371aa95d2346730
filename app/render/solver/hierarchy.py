"""The operator of a grid and of coarser and coarser ones, each by Galerkin's product from the one before."""

from dataclasses import dataclass

import moderngl
import numpy as np

from app.render.gpu import release
from app.render.programs import Names, programs_of
from core.arrays import Floats

PLANES = 6
"""Coefficients of a node (see `levels.glsl`)."""
_BOTTOM = 400
"""Nodes of the coarsest grid at most: its system is solved by a dense inverse."""
_TILE, _LINE = (32, 8), 256
"""Nodes that a group of a shader has, of a grid and of a plain row of numbers."""


@dataclass(frozen=True, eq=False)
class Level:
    """One grid of the hierarchy."""

    shape: tuple[int, int]
    first: int
    """Nodes of all finer grids."""
    uniforms: moderngl.Buffer
    """Shape and first node of this grid and the next coarser one."""

    @property
    def size(self) -> int:
        """How many nodes it has."""
        return self.shape[0] * self.shape[1]

    @property
    def tiles(self) -> tuple[int, int]:
        """Groups of threads for all its nodes."""
        return -(-self.shape[1] // _TILE[0]), -(-self.shape[0] // _TILE[1])

    @property
    def rows_of_threads(self) -> int:
        """The same for shaders that know no rows and columns."""
        return -(-self.size // _LINE)


class Hierarchy:
    """Grids from the finest to one of a few hundred nodes, and the operator's coefficients on each."""

    def __init__(self, context: moderngl.Context, shape: tuple[int, int]) -> None:
        self._context, self._programs = context, programs_of(context)
        shapes = [shape]
        while shapes[-1][0] * shapes[-1][1] > _BOTTOM:
            rows, columns = shapes[-1]
            shapes.append(((rows + 1) // 2, (columns + 1) // 2))
        self.levels: list[Level] = []
        self.count = 0
        """Nodes of all grids."""
        for (rows, columns), coarser in zip(shapes, [*shapes[1:], shapes[-1]], strict=True):
            after = self.count + rows * columns
            uniforms = np.array([rows, columns, self.count, 0, *coarser, after, 0], np.int32)
            self.levels.append(Level((rows, columns), self.count, context.buffer(uniforms.tobytes())))
            self.count = after
        self.coefficients = context.buffer(reserve=4 * PLANES * self.count)
        self._inverse = context.buffer(reserve=4 * self.levels[-1].size ** 2)

    def run(
        self,
        name: str,
        level: Level,
        groups: tuple[int, int] | None = None,
        defined: Names = (),
        **uniforms: int,
    ) -> None:
        """Run a shader, with names `defined`, by default once for every node of a level."""
        level.uniforms.bind_to_uniform_block(0)
        shader = self._programs.compute(f"multigrid/{name}.comp", defined)
        for uniform, value in uniforms.items():
            shader[uniform] = value
        shader.run(*(groups or level.tiles))
        self._context.memory_barrier()

    def bind(self) -> None:
        """Let the shaders read the coefficients."""
        self.coefficients.bind_to_storage_buffer(0)

    def bind_bottom(self) -> None:
        """Let `bottom.comp` read the coarsest operator's inverse."""
        self._inverse.bind_to_storage_buffer(7)

    def take(self, values: Floats) -> None:
        """Take the matrix of FAT eq. 10 by its entries (R, C, 3), as `laplacian.node_values` has them."""
        self.coefficients.write(_planes(values))
        self.bind()
        for finer, coarser in zip(self.levels[:-1], self.levels[1:], strict=True):
            self.run("galerkin", finer, coarser.tiles)
        bottom = self.levels[-1]
        data = self.coefficients.read(4 * PLANES * bottom.size, offset=4 * PLANES * bottom.first)
        planes = np.frombuffer(data, np.float32).reshape(PLANES, *bottom.shape)
        self._inverse.write(np.ascontiguousarray(_invert(planes.astype(np.float64)), np.float32).tobytes())

    def release(self) -> None:
        """Free the GPU objects."""
        release(*(level.uniforms for level in self.levels), self.coefficients, self._inverse)


def _planes(values: Floats) -> bytes:
    """Return the coefficients of the finest grid, plane by plane, from the entries (R, C, 3) of its matrix."""
    centre, east, south = np.moveaxis(values, -1, 0)
    planes = np.zeros((PLANES, *centre.shape))
    planes[1], planes[2] = east, south
    couplings = east + south
    couplings[:, 1:] += east[:, :-1]
    couplings[1:] += south[:-1]
    planes[0] = centre + couplings
    planes[5] = 1 / (centre - couplings)
    return np.asarray(planes, np.float32).tobytes()


def _invert(planes: Floats) -> Floats:
    """Return the inverse of the operator with these coefficients; 0 where it has empty rows."""
    shape = planes.shape[1:]
    number = np.arange(shape[0] * shape[1]).reshape(shape)
    A = np.zeros((number.size, number.size))
    steps = (
        (planes[1, :, :-1], number[:, :-1], number[:, 1:]),
        (planes[2, :-1], number[:-1], number[1:]),
        (planes[3, :-1, :-1], number[:-1, :-1], number[1:, 1:]),
        (planes[4, :-1, 1:], number[:-1, 1:], number[1:, :-1]),
    )
    for value, here, there in steps:
        A[here, there] = A[there, here] = value
    np.fill_diagonal(A, planes[0].ravel() - A.sum(axis=1))
    live = np.flatnonzero(planes[5])
    inverse = np.zeros_like(A)
    if live.size:
        inverse[np.ix_(live, live)] = np.linalg.inv(A[np.ix_(live, live)])
    return inverse
