"""What features ask of the nodes is worked out around them only."""

import numpy as np
import pytest

from core.arrays import Floats
from core.grid import Grid, find_features
from core.linalg import bands
from core.linalg.laplacian import laplacian
from core.mapping.features.feature_mapping import FeatureMapping


@pytest.mark.parametrize("glides", [False, True])
def test_load_is_that_of_all_nodes(monkeypatch: pytest.MonkeyPatch, *, glides: bool) -> None:
    monkeypatch.setattr(bands, "_NODES", 200)
    mask = np.zeros((160, 200), np.uint8)
    mask[20:50, 30:60] = mask[100:130, 150:200] = 255
    grid = Grid(200, 160, cell_px=5)
    mapping = FeatureMapping(grid, find_features(grid, mask))

    def noise(seed: int) -> Floats:
        return np.random.default_rng(seed).normal(size=(*grid.shape, 2))

    w, z = (noise(seed).view(np.complex128)[..., 0] for seed in (0, 1))
    moves = (mapping.index >= 0) | (grid.outline if glides else False)
    z = np.where(moves, z, w)
    expected = laplacian(mapping._edges, w - z) - laplacian(mapping._own_edges, w)
    np.testing.assert_allclose(mapping._load(w, z, glides=glides), expected, atol=1e-12 * np.abs(expected).max())
