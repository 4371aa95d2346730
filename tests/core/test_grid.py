import math

import cv2
import numpy as np
import pytest

from core.arrays import InputError
from core.grid import Grid, find_features


@pytest.mark.parametrize("size", [(1, 1), (1, 5000), (5000, 1), (16384, 16384), (640, 427), (30, 20)])
def test_nodes_span_the_whole_picture(size: tuple[int, int]) -> None:
    grid = Grid(*size)
    width, height = size
    assert grid.nodes.shape == (grid.rows, grid.columns, 2)
    assert np.array_equal(grid.nodes[0, 0], [-0.5, -0.5])
    assert np.allclose(grid.nodes[-1, -1], [width - 0.5, height - 0.5])


@pytest.mark.parametrize("size", [(640, 427), (16384, 16384), (3000, 400), (1000, 1000)])
def test_a_grid_has_20_000_to_50_000_square_cells(size: tuple[int, int]) -> None:
    grid = Grid(*size)
    assert 20_000 <= grid.size <= 50_000
    assert math.isclose(*grid.cell, rel_tol=0.03)


def test_a_small_picture_gets_no_cell_finer_than_a_pixel() -> None:
    assert Grid(30, 20).cell == (1.0, 1.0)


@pytest.mark.parametrize("cell", [0.0, -1.0, math.nan, math.inf, 1e-3])
def test_an_impossible_cell_is_refused(cell: float) -> None:
    with pytest.raises(InputError, match="cell"):
        Grid(100, 100, cell_px=cell)


def test_quads_run_clockwise_and_are_cut_from_top_left_to_bottom_right() -> None:
    grid = Grid(4, 3, cell_px=1)
    assert grid.quads[0].tolist() == [0, 1, 6, 5]
    assert grid.triangles[:2].tolist() == [[0, 1, 6], [0, 6, 5]]


def test_bilinear_weights_reproduce_points() -> None:
    grid = Grid(50, 30, cell_px=3)
    points = np.random.default_rng(0).uniform([-0.5, -0.5], [49.5, 29.5], (100, 2))
    nodes, weights = grid.weights_at(points)
    assert np.allclose((grid.nodes.reshape(-1, 2)[nodes] * weights[..., None]).sum(axis=1), points)
    assert weights.min() >= -1e-12


def test_nodes_take_the_component_of_their_nearest_pixel() -> None:
    mask = np.zeros((40, 60), np.uint8)
    mask[5:15, 5:15] = 255
    mask[15:20, 15:20] = 128
    mask[30:, 50:] = 200
    mask[25, 25] = 127
    grid = Grid(60, 40, cell_px=2)
    features = find_features(grid, mask)
    assert features.ids.tolist() == [1, 2]
    x, y = (np.clip(np.rint(grid.nodes[..., i]), 0, n - 1).astype(int) for i, n in ((0, 60), (1, 40)))
    assert np.array_equal(features.labels > 0, mask[y, x] > 127)
    assert features.labels[-1, -1] == 2


def test_a_component_between_nodes_is_no_feature() -> None:
    mask = np.zeros((100, 100), np.uint8)
    mask[3, 3] = 255
    mask[50:70, 50:70] = 255
    features = find_features(Grid(100, 100, cell_px=10), mask)
    assert features.ids.tolist() == [2]
    assert len(features) == 1


def test_a_mask_that_covers_everything_is_one_feature() -> None:
    features = find_features(Grid(20, 20), np.full((20, 20), 255, np.uint8))
    assert features.ids.tolist() == [1]
    assert (features.labels == 1).all()


def test_a_mask_of_another_size_is_refused() -> None:
    with pytest.raises(InputError, match="20 x 10"):
        find_features(Grid(20, 20), np.zeros((10, 20), np.uint8))


@pytest.mark.parametrize("seed", range(8))
def test_features_are_numbered_as_in_the_whole_mask_wherever_they_are(seed: int) -> None:
    random = np.random.default_rng(seed)
    mask = np.zeros((61, 83), np.uint8)
    left, top = random.integers(0, 60, 2)
    mask[top:, left:][:30, :40] = random.choice([0, 100, 200], mask[top:, left:][:30, :40].shape, p=[0.6, 0.1, 0.3])
    grid = Grid(83, 61, cell_px=1)
    _, components = cv2.connectedComponents(np.asarray(mask > 127, np.uint8), connectivity=8)
    column, row = (np.rint(line).astype(int) for line in (grid.nodes[0, :, 0], grid.nodes[:, 0, 1]))
    inside = components[np.ix_(row.clip(0, 60), column.clip(0, 82))]
    assert np.array_equal(find_features(grid, mask).labels, inside)
