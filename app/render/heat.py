"""How much a map changes what is small: its size, its angles, its area, quad by quad."""

import numpy as np

from app.model.session import Heat
from core.arrays import Floats, Points, Singles

FULL_ANGLE_DEG = 45.0
"""A right angle that changes by so much is shown in full."""


def measure_heat(rest: Points, shown: Points, heat: Heat) -> Singles:
    """Return what is shown of every quad (R - 1, C - 1), -1 to 1 and beyond, for nodes (R, C, 2) at rest and shown.

    "scale": the binary logarithm of how much lengths change: the contraharmonic mean of those of the map's singular
    values, that is nearly the one that is farther from 0, and 0 where they balance. "area": that of the root of how
    areas change: 1 where they are four times as large. "angle": by how much right angles change, over
    `FULL_ANGLE_DEG`.
    """
    if heat == "area":
        ratio = np.abs(_doubled_areas(shown)) / np.maximum(np.abs(_doubled_areas(rest)), 1e-12)
        return np.asarray(0.5 * np.log2(np.maximum(ratio, 1e-6)), np.float32)
    across, down = _derivatives(rest, shown)
    if heat == "angle":
        sizes = np.maximum(np.abs(across) * np.abs(down), 1e-12)
        sine = np.clip(np.abs((across * down.conj()).real) / sizes, 0, 1)
        return np.asarray(np.degrees(np.arcsin(sine)) / FULL_ANGLE_DEG, np.float32)
    # J = s + o with s a similarity and o a mirrored one: its singular values are |s| + |o| and ||s| - |o||.
    similar, mirrored = np.abs(across - 1j * down) / 2, np.abs(across + 1j * down) / 2
    most, least = (np.log2(np.maximum(v, 1e-3)) for v in (similar + mirrored, np.abs(similar - mirrored)))
    sums = np.maximum(np.abs(most) + np.abs(least), 1e-12)
    return np.asarray((most * np.abs(most) + least * np.abs(least)) / sums, np.float32)


def _derivatives(rest: Points, shown: Points) -> tuple[Floats, Floats]:
    """Return how the map changes across and down (R - 1, C - 1), as x + iy, by the sides of the quads."""
    moved, still = (nodes[..., 0] + 1j * nodes[..., 1] for nodes in (shown, rest))
    across, down = (np.diff(moved, axis=axis) / np.abs(np.diff(still, axis=axis)) for axis in (1, 0))
    return (across[:-1] + across[1:]) / 2, (down[:, :-1] + down[:, 1:]) / 2


def _doubled_areas(nodes: Points) -> Floats:
    """Return twice the signed area of every quad, from its diagonals."""
    falling, rising = nodes[1:, 1:] - nodes[:-1, :-1], nodes[1:, :-1] - nodes[:-1, 1:]
    areas: Floats = falling[..., 0] * rising[..., 1] - falling[..., 1] * rising[..., 0]
    return areas
