"""Sums over the edges of quads as a five-point stencil on the grid: the matrix of FAT eqs. 9 and 10.

The equations of FAT eqs. 3 and 4 are per quad; an inner edge belongs to two quads. With w the squared weight of a quad
and d the difference along an edge, Σ_Q w_Q Σ_e |d z - τ|² has the normal equations K z = dᵀ(w τ), K = dᵀ w d.
"""

from typing import TypeVar

import numpy as np
import scipy
from numpy.typing import NDArray

from core.arrays import Bools, Floats

_Number = TypeVar("_Number", np.float64, np.complex128)
EdgeWeights = tuple[Floats, Floats]
"""Weights of the edges across (R, C-1) and down (R-1, C)."""


def edge_weights(quad_weights: NDArray[_Number]) -> tuple[NDArray[_Number], NDArray[_Number]]:
    """Return the sums over the quads of each edge across (R, C-1) and down (R-1, C) of values per quad (R-1, C-1)."""
    rows, columns = quad_weights.shape
    across = np.zeros((rows + 1, columns), quad_weights.dtype)
    down = np.zeros((rows, columns + 1), quad_weights.dtype)
    across[:-1] = quad_weights
    across[1:] += quad_weights
    down[:, :-1] = quad_weights
    down[:, 1:] += quad_weights
    return across, down


def divergence(across: NDArray[_Number], down: NDArray[_Number]) -> NDArray[_Number]:
    """Return dᵀ of edge vectors, per node (R, C)."""
    total = np.zeros((across.shape[0], down.shape[1]), np.result_type(across, down))
    total[:, 1:] += across
    total[:, :-1] -= across
    total[1:] += down
    total[:-1] -= down
    return total


def laplacian(weights: EdgeWeights, z: NDArray[_Number]) -> NDArray[_Number]:
    """Return K z = dᵀ w d z, per node (R, C): AᵀA of FAT eq. 10 times z, A being that of FAT eq. 9."""
    return divergence(weights[0] * np.diff(z, axis=1), weights[1] * np.diff(z, axis=0))


def steps(z: NDArray[_Number], columns: int) -> tuple[NDArray[_Number], NDArray[_Number]]:
    """Return the differences (N - 1,) and (N - columns,) from nodes (N,), row by row, to those to the right and below.

    Beyond the end of a row lies the beginning of the next one. Along one row of all numbers an operation takes a third
    of the time that it takes within a grid.
    """
    return z[1:] - z[:-1], z[columns:] - z[:-columns]


def collect_steps(across: NDArray[_Number], down: NDArray[_Number]) -> NDArray[_Number]:
    """Return dᵀ, per node (N,), of vectors of these edges, those across 0 at the end of each row."""
    total = np.zeros(len(across) + 1, across.dtype)
    total[1:] = across
    total[:-1] -= across
    columns = len(total) - len(down)
    total[columns:] += down
    total[:-columns] -= down
    return total


def pattern(shape: tuple[int, int]) -> "scipy.sparse.csc_array":
    """Return ones where K's lower triangle has entries on a grid of `shape`, whatever the weights."""
    number = np.arange(shape[0] * shape[1]).reshape(shape)
    stored = find_stored(shape)
    rows = np.stack([number, number + 1, number + shape[1]], axis=-1)[stored]
    starts = np.concatenate([[0], np.cumsum(stored.sum(axis=-1))])
    return scipy.sparse.csc_array((np.ones(len(rows)), rows, starts), shape=(number.size, number.size))


def node_values(weights: EdgeWeights, free: Bools) -> Floats:
    """Return the entries of K of every node itself, with its right and with its lower neighbour, (R, C, 3).

    K is AᵀA of FAT eq. 10 for the nodes that are not held (FAT eq. 5). A node that is not free gets the equation x = 0.
    """
    across, down = weights
    values = np.zeros((*free.shape, 3))
    values[:, :-1, 1] = -across * (free[:, :-1] & free[:, 1:])
    values[:-1, :, 2] = -down * (free[:-1] & free[1:])
    degree = np.zeros(free.shape)
    degree[:, 1:] += across
    degree[:, :-1] += across
    degree[1:] += down
    degree[:-1] += down
    values[..., 0] = np.where(free, degree, 1.0)
    return values


def find_stored(shape: tuple[int, ...]) -> Bools:
    """Return which of these entries (R, C, 3) there are: those stored in K's lower triangle, column by column."""
    stored = np.ones((*shape, 3), bool)
    stored[:, -1, 1] = False
    stored[-1, :, 2] = False
    return stored
