import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import core.masks.brush
from core.arrays import Bytes, Points, Singles
from core.grid import Grid
from core.masks.brush import Stroke, Tip
from core.mesh import Mesh
from core.rasters.raster import Box, Raster

SIZE = (300, 200)


def flat() -> Mesh:
    grid = Grid(*SIZE, cell_px=10.0)
    return Mesh(grid, grid.nodes)


def drawn(mesh: Mesh, points: list[tuple[float, float]], tip: Tip, start: Raster | None = None, **kind: bool) -> Bytes:
    stroke = Stroke(start or Raster.filled(*SIZE), **kind)
    for a, b in zip(points, points[1:] or points, strict=False):
        stroke.extend(mesh, np.array(a), np.array(b), tip)
    return stroke.mask.array


def distances(mesh: Mesh, centre: tuple[float, float]) -> Singles:
    x, y = mesh.canvas_of_box((0, 0, *SIZE))
    return np.asarray(np.hypot(x - np.float32(centre[0]), y - np.float32(centre[1])))


@given(st.floats(1, 80), st.floats(0, 1), st.floats(0, 300), st.floats(0, 200))
def test_a_dab_is_round_full_within_and_empty_without(radius: float, hardness: float, x: float, y: float) -> None:
    tip = Tip(radius, hardness)
    mask, far = drawn(flat(), [(x, y)], tip), distances(flat(), (x, y))
    assert (mask[far <= tip.core_px - 1e-3] == 255).all()
    assert (mask[far >= tip.reach_px + 1e-3] == 0).all()
    assert (mask[far < radius * (1 + hardness) / 2 - 0.01] > 127).all()


def test_a_dab_is_round_on_a_stretched_picture() -> None:
    grid = Grid(*SIZE, cell_px=10.0)
    mesh = Mesh(grid, grid.nodes * [3.0, 1.0])
    mask = drawn(mesh, [(450.0, 100.0)], Tip(60, 1.0))
    rows, columns = np.flatnonzero(mask.max(axis=1) > 127), np.flatnonzero(mask.max(axis=0) > 127)
    assert len(rows) in (119, 120, 121)
    assert len(columns) in (39, 40, 41)


def test_a_stroke_is_the_most_of_its_dabs() -> None:
    tip = Tip(12, 0.3)
    stroke = drawn(flat(), [(40, 50), (140, 90)], tip).astype(int)
    dabs = np.max([drawn(flat(), [(x, 50 + (x - 40) * 0.4)], tip) for x in np.arange(40, 140.5, 0.5)], axis=0)
    assert np.abs(stroke - dabs).max() <= 2


def test_erasing_takes_away_what_painting_brought() -> None:
    tip = Tip(20, 0.5)
    painted = Raster.from_array(drawn(flat(), [(50, 50), (90, 90)], tip))
    assert not (drawn(flat(), [(50, 50), (90, 90)], Tip(40, 1.0), painted, erase=True)).any()
    assert (drawn(flat(), [(250, 150)], tip, painted, erase=True) == painted.array).all()


def test_crossing_itself_does_not_build_up() -> None:
    tip = Tip(20, 0.0)
    once = drawn(flat(), [(50, 50), (120, 50)], tip)
    again = drawn(flat(), [(50, 50), (120, 50), (50, 50), (120, 50)], tip)
    assert np.abs(once.astype(int) - again).max() <= 1


def test_the_finest_brush_paints_one_pixel() -> None:
    mask = drawn(flat(), [(30, 40)], Tip(0.5, 1.0))
    assert np.argwhere(mask > 127).tolist() == [[40, 30]]


def test_a_dab_beside_the_picture_changes_nothing() -> None:
    start = Raster.filled(*SIZE)
    stroke = Stroke(start)
    stroke.extend(flat(), np.array([-500.0, 0.0]), np.array([-400.0, 0.0]), Tip(30, 1.0))
    assert stroke.mask is start


def test_only_tiles_under_the_stroke_are_new() -> None:
    start = Raster.filled(*SIZE)
    stroke = Stroke(start)
    stroke.extend(flat(), np.array([20.0, 20.0]), np.array([40.0, 20.0]), Tip(10, 1.0))
    assert [box for box, _ in stroke.mask.changed_boxes(start)] == [(0, 0, 128, 128)]


def test_what_lies_behind_the_last_piece_is_not_covered_again(monkeypatch: pytest.MonkeyPatch) -> None:
    grid, tip = Grid(1500, 1000), Tip(300, 0.97)
    mesh, ends = Mesh(grid, grid.nodes), [np.array([x, 500.0]) for x in (700.0, 720.0, 740.0)]
    looked, look = [], Mesh.canvas_of_box

    def counted(mesh: Mesh, box: Box) -> Singles:
        looked.append(box)
        return look(mesh, box)

    monkeypatch.setattr(Mesh, "canvas_of_box", counted)
    on = Stroke(Raster.filled(1500, 1000))
    on.extend(mesh, ends[0], ends[1], tip)
    looked.clear()
    on.extend(mesh, ends[1], ends[2], tip)
    assert min(box[2] for box in looked) > 720
    anew = Stroke(on.mask)
    anew.extend(mesh, ends[1], ends[2], tip)
    assert min(box[2] for box in looked) < 720
    assert np.array_equal(anew.mask.array, on.mask.array)


@pytest.mark.parametrize("erase", [False, True])
def test_a_wide_soft_edge_is_worked_out_at_few_pixels_to_the_same_level(
    monkeypatch: pytest.MonkeyPatch, erase: bool
) -> None:
    grid = Grid(1300, 1101, cell_px=20.0)
    x, y = np.moveaxis(grid.nodes, -1, 0)
    mesh = Mesh(grid, np.stack([0.7 * x + 20 * np.sin(y / 200), 0.6 * y + 15 * np.cos(x / 150)], axis=-1))
    start = Raster.filled(1300, 1101, 200 * erase)

    def painted() -> Raster:
        stroke = Stroke(start, erase=erase)
        for a, b in (((100.0, 80.0), (100.0, 80.0)), ((100.0, 80.0), (420.0, 300.0)), ((420.0, 300.0), (700.0, 650.0))):
            stroke.extend(mesh, np.array(a), np.array(b), Tip(250.0, 0.3))
        return stroke.mask

    few, look = [], Mesh.canvas_of_crossings

    def counted(mesh: Mesh, x: Points, y: Points) -> Singles:
        few.append(len(x) * len(y))
        return look(mesh, x, y)

    with monkeypatch.context() as patch:
        patch.setattr(Mesh, "canvas_of_crossings", counted)
        found = painted()
    monkeypatch.setattr(core.masks.brush, "STEPS_PX", ())
    exact = painted()
    assert sum(few) < 1300 * 1101 / 10
    apart = np.abs(found.array.astype(int) - exact.array)
    assert (exact.array != start.array).mean() > 0.4
    assert apart.max() <= 1


def test_a_stretched_picture_is_painted_at_every_pixel_that_needs_it() -> None:
    grid = Grid(600, 400, cell_px=20.0)
    stroke = Stroke(Raster.filled(600, 400))
    mesh = Mesh(grid, grid.nodes * [1.0, 40.0])
    stroke.extend(mesh, np.array([300.0, 8000.0]), np.array([300.0, 8000.0]), Tip(200.0, 0.0))
    rows = stroke.mask.array[:, 300].astype(int)
    share = np.clip(1 - np.abs(40.0 * np.arange(400) - 8000.0) / 200.0, 0, 1)
    assert np.abs(rows - np.rint(255 * share * share * (3 - 2 * share))).max() <= 1
