"""Random masks, warps, sizes and handles: nothing folds, features are exact, nothing warns."""

import cv2
import numpy as np
import pytest

from core.arrays import Bytes, Points
from core.grid import Grid, find_features
from core.mapping.folds import find_folded_quads
from core.mapping.handles.handles import Handles
from core.mapping.handles.plate import Frame
from core.mapping.jacobians import as_complex
from core.mapping.options import Keep, MappingOptions
from core.mapping.warping import warp_grid
from core.warps.presets import PRESETS, make_warp


def blots(chance: np.random.Generator, width: int, height: int) -> Bytes:
    mask = np.zeros((height, width), np.uint8)
    for _ in range(chance.integers(1, 5)):
        one, other = ((int(x), int(y)) for x, y in chance.integers(0, [width, height], (2, 2)))
        if chance.random() < 0.6:
            cv2.circle(mask, one, int(chance.integers(5, max(7, min(width, height) // 4))), 255, -1)
        else:
            cv2.line(mask, one, other, 255, int(chance.integers(3, 25)))
    return mask


def bent(chance: np.random.Generator, grid: Grid) -> Points:
    """Return W at the nodes: a preset, a new size or both."""
    z = grid.nodes
    if chance.random() < 0.5:
        name = str(chance.choice(list(PRESETS)))
        z = make_warp(name, grid.width_px, grid.height_px, bend=float(chance.uniform(-50, 50)))(z)
    return (z + 0.5) * chance.uniform(0.6, 1.7, 2) - 0.5 if chance.random() < 0.5 else z


@pytest.mark.parametrize("seed", range(24))
def test_nothing_folds_and_features_are_exact(seed: int) -> None:
    chance = np.random.default_rng(seed)
    width, height = (int(side) for side in chance.integers(60, 260, 2))
    grid = Grid(width, height, cell_px=4)
    keep: Keep = "similarity" if chance.random() < 0.6 else "rigid"
    frame: Frame = "held" if chance.random() < 0.8 else "free"
    plain, count = bent(chance, grid), int(chance.integers(0, 7))
    at = chance.uniform(0, 1, (count, 2)) * [width - 1, height - 1]
    nodes, weights = grid.weights_at(at)
    there = (plain.reshape(-1, 2)[nodes] * weights[..., None]).sum(axis=1)
    to = there + chance.normal(0, chance.choice([3, 15, 60]), (count, 2))
    features = find_features(grid, blots(chance, width, height))
    found = warp_grid(grid, features, plain, options=MappingOptions(keep=keep, frame=frame), handles=Handles(at, to))
    assert np.isfinite(found.warped).all()
    assert find_folded_quads(as_complex(plain)).any() or not found.folded.any()
    if keep == "similarity":
        assert max((feature.residual for feature in found.features), default=0.0) < 1e-9
