"""Windows of a grid around what is wrong in a map: folded quads and points off their targets."""

import cv2
import numpy as np

from core.arrays import Bools, Floats
from core.mapping.folds import find_folded_quads
from core.mapping.injective.levels import GridLevel
from core.mapping.jacobians import Complexes
from core.mapping.tolerances import MET_PX


def count_folds(level: GridLevel, z: Complexes) -> int:
    """Return how many quads of a map (N,) are folded."""
    return int(find_folded_quads(z.reshape(level.grid.shape)).sum())


def misses(level: GridLevel, z: Complexes) -> Floats:
    """Return how far points are from their targets (k,) in a map (N,), in pixels."""
    return np.asarray(np.abs(level.constraints.probes.read(level.grid, z) - level.constraints.to))


def wrong_nodes(level: GridLevel, z: Complexes, *, points: bool = True) -> Bools:
    """Return the corners (N,) of quads of a map that are folded or, if wanted, hold a point off its target."""
    wrong = np.zeros(level.grid.size, bool)
    wrong[level.grid.quads[find_folded_quads(z.reshape(level.grid.shape)).ravel()]] = True
    if points:
        nodes, _ = level.constraints.probes.on(level.grid)
        wrong[nodes[misses(level, z) > MET_PX]] = True
    return wrong


def widen(level: GridLevel, marked: Bools, reach: int) -> Bools:
    """Return the nodes (N,) within `reach` rows and columns of marked ones."""
    size = 2 * reach + 1
    grown = cv2.dilate(marked.reshape(level.grid.shape).astype(np.uint8), np.ones((size, size), np.uint8))
    return np.asarray(grown.ravel() > 0)


def window_around(level: GridLevel, z: Complexes, reach: int, *, bodies: bool = True) -> Bools:
    """Return the nodes (N,) around what is wrong and, if wanted, around all of the bodies that come near it."""
    return around(level, wrong_nodes(level, z), reach, bodies=bodies)


def around(level: GridLevel, marked: Bools, reach: int, *, bodies: bool) -> Bools:
    """Return the nodes (N,) around marked ones and, if wanted, around all of the bodies that come near them."""
    window = widen(level, marked, reach)
    if bodies:
        near = np.unique(level.index[window & (level.index >= 0)])
        window |= widen(level, np.isin(level.index, near), reach)
    return window


def nearness(level: GridLevel, marked: Bools, reach: float) -> Floats:
    """Return 1 on marked nodes (N,) and around them, falling to 0 over `reach` cells in all."""
    clear = (~marked).reshape(level.grid.shape).astype(np.uint8)
    far = cv2.distanceTransform(clear, cv2.DIST_L2, cv2.DIST_MASK_5).ravel()
    return np.asarray(np.clip(1.5 * (1 - far / reach), 0, 1), np.float64)
