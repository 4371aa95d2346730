"""What a part of the output reads is found by blocks of triangles, and is all that its pixels need."""

import numpy as np
import pytest

from app.render import source_footprint
from app.render.source_footprint import SourceFootprint
from app.render.sources.source import Box
from core.arrays import Points
from core.grid import Grid
from core.mesh import Mesh
from tests.core.meshes import jacobians_of

STRETCH = 1.5


def waved(rest: Points, rng: np.random.Generator) -> Points:
    x, y = np.moveaxis(rest / rest.max(), -1, 0)
    wave = np.stack([np.sin(5 * y), np.cos(4 * x)], axis=-1)
    moved: Points = rest * rng.uniform(0.2, 2) + 20 * wave + rng.normal(0, rng.choice([0, 2]), rest.shape)
    return moved


def boxes(moved: Points, rng: np.random.Generator) -> list[Box]:
    corners = rng.uniform(-40, moved.max(), (30, 2)).astype(int).tolist()
    return [(x, y, x + side, y + side) for (x, y), side in zip(corners, [1, 16, 200] * 10, strict=True)]


@pytest.mark.parametrize("seed", range(6))
def test_looking_in_blocks_finds_what_looking_at_all_triangles_finds(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(seed)
    rest = Grid(*rng.integers(100, 900, 2).tolist(), cell_px=9).nodes
    moved = waved(rest, rng)
    by_blocks = SourceFootprint.of(rest, moved)
    monkeypatch.setattr(source_footprint, "BLOCK", 10**6)
    whole = SourceFootprint.of(rest, moved)
    assert len(by_blocks.starts) > len(whole.starts) == 2
    for box in boxes(moved, rng):
        assert by_blocks.read_for(box, least_stretch=STRETCH) == whole.read_for(box, least_stretch=STRETCH)


@pytest.mark.parametrize("seed", range(6))
def test_it_holds_the_source_of_every_pixel_and_its_level(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = Grid(400, 300, cell_px=11)
    moved = waved(grid.nodes, rng)
    found, mesh = SourceFootprint.of(grid.nodes, moved), Mesh(grid, moved)
    for box in boxes(moved, rng):
        read = found.read_for(box, least_stretch=STRETCH)
        (left, top, right, bottom), level = read[:2] if read else ((0, 0, 1, 1), 0)
        pixels = np.stack(np.meshgrid(np.arange(box[0], box[2]), np.arange(box[1], box[3])), -1).reshape(-1, 2)
        places = mesh.image_from_canvas(pixels[::23].astype(float))
        places = places[~np.isnan(places).any(axis=1)]
        assert (places > [left + 2, top + 2]).all() or not len(places)
        assert (places < [right - 2, bottom - 2]).all() or not len(places)
        if len(places):
            assert read is not None
            shrink = np.linalg.svd(np.linalg.inv(jacobians_of(mesh, places)), compute_uv=False).min()
            assert level <= max(np.log2(shrink / STRETCH) + 1, 0)


def test_what_is_drawn_nowhere_reads_nothing_but_slivers_may_be_anywhere() -> None:
    rest = Grid(40, 30, cell_px=5).nodes
    assert SourceFootprint.of(rest, rest + 500).read_for((0, 0, 8, 8), least_stretch=STRETCH) is None
    read = SourceFootprint.of(rest, np.zeros_like(rest)).read_for((0, 0, 8, 8), least_stretch=STRETCH)
    assert read == ((0, 0, 1, 1), 0, None, ())


def test_it_knows_where_all_is_shrunk_or_enlarged() -> None:
    rest = Grid(400, 300, cell_px=10).nodes
    moved = rest.copy()
    moved[..., 0] = np.where(rest[..., 0] < 200, rest[..., 0] / 2, 100 + 2 * (rest[..., 0] - 200))
    footprint = SourceFootprint.of(rest, moved)
    of = {x: footprint.read_for((x, 50, x + 40, 90), least_stretch=STRETCH) for x in (20, 80, 200)}
    filters = [None if read is None else read.filters for read in of.values()]
    assert filters == [("AVERAGED",), (), ("INTERPOLATED",)]


def test_it_knows_where_rows_are_short() -> None:
    rest = Grid(400, 300, cell_px=10).nodes
    found = [
        SourceFootprint.of(rest, rest / shrunk).read_for((20, 20, 60, 60), least_stretch=STRETCH)
        for shrunk in (1.2, 1.3)
    ]
    assert [read and read.filters for read in found] == [("AVERAGED", "NARROW"), ("AVERAGED",)]


def test_it_knows_the_finest_and_the_coarsest_level() -> None:
    rest = Grid(800, 800, cell_px=10).nodes
    moved = rest / 8
    moved[:, 40:, 0] += np.maximum(rest[:, 40:, 0] - 400, 0) * 7 / 8
    moved[40:, :, 1] += np.maximum(rest[40:, :, 1] - 400, 0) * 7 / 8
    footprint = SourceFootprint.of(rest, moved)
    boxes = [(10, 10, 40, 40), (100, 100, 140, 140), (40, 40, 60, 60)]
    reads = [footprint.read_for(box, least_stretch=STRETCH) for box in boxes]
    assert [read and (read.level, read.top) for read in reads] == [(2, 2), (0, 0), (0, 2)]
