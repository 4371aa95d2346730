"""Bases of a plane lattice: reduction, canonical order, sublattices."""

import numpy as np

from core.arrays import Floats, Ints


def reduce(basis: Floats) -> Floats:
    """Return the shortest basis of the same lattice (Lagrange, Gauss), in canonical order; columns are vectors."""
    a, b = basis[:, 0].copy(), basis[:, 1].copy()
    for _ in range(64):
        if a @ a > b @ b:
            a, b = b, a
        k = np.rint(a @ b / max(float(a @ a), 1e-12))
        if k == 0:
            break
        b = b - k * a
    return canonical(np.stack([a, b], -1))


def canonical(basis: Floats) -> Floats:
    """Return the vectors ordered and signed so that the first points right, the second down, determinant positive."""
    a, b = basis[:, 0], basis[:, 1]
    if abs(a[0]) * np.linalg.norm(b) < abs(b[0]) * np.linalg.norm(a):
        a, b = b, a
    a = a if a[0] >= 0 else -a
    b = b if a[0] * b[1] - a[1] * b[0] >= 0 else -b
    return np.stack([a, b], -1)


def sublattices(index: int) -> list[Ints]:
    """Return every sublattice of Z² of that index as a 2 x 2 matrix whose columns span it (Hermite normal form)."""
    return [
        np.array([[a, b], [0, index // a]], np.int64) for a in range(1, index + 1) if index % a == 0 for b in range(a)
    ]
