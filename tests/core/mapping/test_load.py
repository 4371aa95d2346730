"""What features ask of the nodes, and W of features, is worked out at their rims only."""

import numpy as np
import pytest

from core.arrays import Floats
from core.grid import Grid, find_features
from core.linalg.cubic_convolution import Smooth
from core.linalg.laplacian import edge_weights, laplacian
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.pose import Start
from core.mapping.features.reduced_system import as_one
from core.mapping.features.sizes import smaller_scales
from core.mapping.jacobians import as_complex, linear_parts
from core.mapping.tolerances import TIE

GRID = Grid(200, 160, cell_px=5)


def mapping() -> FeatureMapping:
    mask = np.zeros((160, 200), np.uint8)
    mask[20:50, 30:60] = mask[100:130, 150:200] = mask[51:90, 34:80] = 255
    return FeatureMapping(GRID, find_features(GRID, mask))


def noise(seed: int) -> Floats:
    return np.random.default_rng(seed).normal(size=(*GRID.shape, 2))


@pytest.mark.parametrize("glides", [False, True])
def test_load_is_that_of_all_nodes(*, glides: bool) -> None:
    found = mapping()
    w, z = (noise(seed).view(np.complex128)[..., 0] for seed in (0, 1))
    moves = (found.index >= 0) | (GRID.outline if glides else False)
    z = np.where(moves, z, w)
    start = Start(Smooth(w), found._held, z.ravel()[found._held.nodes])
    assert found._placement is not None
    fields = found._placement.fields
    c = noise(2).view(np.complex128).ravel()[: 2 * len(fields)]
    r = laplacian(found._edges, w - z) - laplacian(edge_weights(found.follow_feature), w)
    expected = r.copy()
    for i, field in enumerate(fields):
        expected[field.window] += c[i] * field.load[0] + c[len(fields) + i] * field.load[1]
    values, nodes = found._load(start, c)
    load = np.zeros(GRID.size, np.complex128)
    load[nodes] = as_one(values)
    np.testing.assert_allclose(load, np.where(found.free, expected, 0).ravel(), atol=1e-12 * np.abs(r).max())
    np.testing.assert_array_equal(start.onto.moved(np.zeros(GRID.size, np.complex128)), z)
    for field in fields:
        weighed = field.phi.conj().reshape(2, -1) @ (r + TIE * w)[field.window].ravel()
        weighed[0] += np.vdot(field.halo, z[field.window])
        np.testing.assert_allclose(field.weighed(start), weighed, atol=1e-9 * np.abs(weighed).max())


def test_sizes_are_those_of_the_mean_linear_part_of_all_quads_inside() -> None:
    found = mapping()
    w, roles, chosen = as_complex(GRID.nodes + 3 * noise(4)), found._roles, np.array([2, 0])
    parts = linear_parts(GRID, w)
    inside = [roles.touched & (roles.owner == i) for i in chosen]
    similar, opposite = (np.array([part[quads].mean() for quads in inside]) for part in (parts.similar, parts.opposite))
    sizes = smaller_scales(GRID, w, roles, chosen)
    np.testing.assert_allclose(sizes, np.abs(np.abs(similar) - np.abs(opposite)), rtol=1e-12)
