"""Bases of a plane lattice: reduction, canonical order, sublattices."""

from collections.abc import Iterable

import numpy as np

from core.arrays import Floats, Ints

LEAST_SINE = 0.35
"""Of the angle between the vectors of a basis."""
APART = 0.2
"""Steps from which two lattices are distinct."""
ABOUT = 1.5
"""Times by which the side of a texel is larger or smaller at most than what a user says of it."""


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


def spans(basis: Floats) -> bool:
    """Return whether the vectors of a basis (2, 2) are far enough from being parallel."""
    return bool(abs(np.linalg.det(basis)) >= LEAST_SINE * np.prod(np.linalg.norm(basis, axis=0)))


def is_about(basis: Floats, side_px: float | None) -> bool:
    """Return whether a texel of vectors (2, 2) has about that side, pixels, if one is known."""
    return side_px is None or 1 / ABOUT < float(np.sqrt(abs(np.linalg.det(basis)))) / side_px < ABOUT


def keep_distinct(bases: Iterable[Floats]) -> list[Floats]:
    """Return the reduced bases (2, 2) without those of which one before is nearly the same."""
    kept: list[Floats] = []
    for basis in bases:
        others = np.array(kept).reshape(-1, 2, 2)
        if not (np.abs(np.linalg.solve(others, basis) - np.eye(2)).max((1, 2)) < APART).any():
            kept.append(basis)
    return kept


def sublattices(index: int) -> list[Ints]:
    """Return every sublattice of Z² of that index as a 2 x 2 matrix whose columns span it (Hermite normal form)."""
    return [
        np.array([[a, b], [0, index // a]], np.int64) for a in range(1, index + 1) if index % a == 0 for b in range(a)
    ]
