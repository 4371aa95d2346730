import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from core.arrays import Points
from core.grid import Grid
from core.mesh import Mesh


def bent(grid: Grid, *, seed: int, strength: float = 0.24) -> Mesh:
    """Move every node by less than a quarter cell, which folds no quad, then turn, stretch and shift the whole."""
    random = np.random.default_rng(seed)
    moved = grid.nodes + random.uniform(-strength, strength, grid.nodes.shape) * grid.cell
    turn = np.array([[0.8, -0.7], [0.6, 0.9]]) * random.uniform(0.5, 2)
    return Mesh(grid, moved @ turn.T + random.uniform(-100, 100, 2))


grids = st.builds(
    lambda width, height, cell: Grid(width, height, cell_px=cell),
    st.integers(20, 300),
    st.integers(20, 300),
    st.floats(4, 30),
)
seeds = st.integers(0, 1 << 30)


def places(grid: Grid, seed: int, count: int = 50) -> Points:
    return np.random.default_rng(seed).uniform(-0.5, np.array([grid.width_px, grid.height_px]) - 0.5, (count, 2))


@given(grids, seeds)
def test_the_map_back_undoes_the_map_there(grid: Grid, seed: int) -> None:
    mesh, points = bent(grid, seed=seed), places(grid, seed)
    assert np.allclose(mesh.image_from_canvas(mesh.canvas_from_image(points)), points, atol=1e-6)


@given(grids, seeds)
def test_nodes_go_where_they_are_put(grid: Grid, seed: int) -> None:
    mesh = bent(grid, seed=seed)
    assert np.allclose(mesh.canvas_from_image(grid.nodes), mesh.warped)


def test_nothing_is_found_beside_the_picture() -> None:
    grid = Grid(50, 40, cell_px=5.0)
    found = Mesh(grid, grid.nodes).image_from_canvas(
        np.array([[-3.0, 5.0], [20.0, 39.6], [200.0, 200.0], [10.0, 10.0]])
    )
    assert np.isnan(found[:3]).all()
    assert np.isnan(Mesh(grid, grid.nodes).image_from_canvas(np.array([[500.0, 500.0]]))).all()
    assert np.allclose(found[3], [10, 10])


def test_of_a_fold_the_upright_sheet_wins() -> None:
    grid = Grid(40, 10, cell_px=10.0)
    warped = grid.nodes.copy()
    warped[:, 2, 0] = 5.0
    found = Mesh(grid, warped).image_from_canvas(np.array([[7.0, 4.0]]))
    assert found[0, 0] < 10 or found[0, 0] > 20


@given(grids, seeds)
def test_pixels_of_a_box_are_mapped_like_points(grid: Grid, seed: int) -> None:
    mesh = bent(grid, seed=seed)
    box = (3, 2, min(20, grid.width_px), min(17, grid.height_px))
    pixels = np.stack(np.meshgrid(np.arange(box[0], box[2]), np.arange(box[1], box[3])), axis=-1).astype(float)
    found = np.moveaxis(mesh.canvas_of_box(box), 0, -1)
    assert np.allclose(found, mesh.canvas_from_image(pixels), atol=2e-3)
    corners = mesh.nodes_of_box(box)
    inside = found.reshape(-1, 2)
    assert (inside >= corners.min(axis=0) - 1e-3).all()
    assert (inside <= corners.max(axis=0) + 1e-3).all()


@given(grids, seeds)
def test_the_box_near_a_place_holds_its_pixel(grid: Grid, seed: int) -> None:
    mesh, points = (
        bent(grid, seed=seed),
        np.rint(places(grid, seed, 5)).clip(0, [grid.width_px - 1, grid.height_px - 1]),
    )
    for point, canvas in zip(points, mesh.canvas_from_image(points), strict=True):
        box = mesh.box_near(canvas - 1, canvas + 1)
        assert box is not None
        assert box[0] <= point[0] < box[2]
        assert box[1] <= point[1] < box[3]


@given(grids, seeds)
def test_the_box_near_a_rectangle_is_that_of_the_quads_that_meet_it(grid: Grid, seed: int) -> None:
    mesh, random = bent(grid, seed=seed), np.random.default_rng(seed)
    low, high = mesh.bounds
    a, b = np.sort(random.uniform(low - 20, high + 20, (2, 2)), axis=0)
    corners = np.stack([mesh.warped[:-1, :-1], mesh.warped[:-1, 1:], mesh.warped[1:, 1:], mesh.warped[1:, :-1]])
    rows, columns = np.nonzero(((corners.min(axis=0) <= b) & (corners.max(axis=0) >= a)).all(axis=-1))
    box = mesh.box_near(a, b)
    if not len(rows):
        assert box is None
        return
    width, height = grid.cell
    assert box is not None
    assert box[:2] == (int(columns.min() * width), int(rows.min() * height))
    assert box[2] == min(int(np.ceil((columns.max() + 1) * width)) + 1, grid.width_px)
    assert box[3] == min(int(np.ceil((rows.max() + 1) * height)) + 1, grid.height_px)
