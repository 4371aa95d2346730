import numpy as np
import pytest

from app.model.shapes import Circle
from app.tools.cloth import lattice
from app.tools.cloth.lattice_web import Web, web_of
from core.arrays import Ints
from core.document.overlay_settings import LatticeVertices
from core.overlay.detection.lattice import neighbour_rows
from tests.app.overlay.driver import OverlayDriver


def keys(columns: int, rows: int) -> Ints:
    """Return whole coordinates, row by row."""
    return np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2)


def test_vertices_in_a_row_or_a_column_make_a_chain() -> None:
    web = Web(keys(4, 3), keys(4, 3).astype(np.float64) * 10)
    assert web.step == pytest.approx(10.0)
    assert sorted(len(chain) for chain in web.chains) == [3, 3, 3, 3, 4, 4, 4]


@pytest.mark.parametrize("count", [0, 1, 3])
def test_vertices_without_neighbours_are_drawn_and_nothing_between_them(
    drive: OverlayDriver, monkeypatch: pytest.MonkeyPatch, count: int
) -> None:
    apart = 2.0 * np.arange(count)[:, None] * [1, 1]
    alone = LatticeVertices(apart, 0.2 + 0.1 * apart)
    web = web_of(alone, (400, 200))
    assert web.step == np.inf
    assert not len(web.quads(np.ones(count, np.bool_)))
    monkeypatch.setattr(lattice, "vertices", lambda _: alone)
    drive.tool("lattice").frame()
    shapes = lattice.overlay(drive.editor)
    assert [type(shape) for shape in shapes] == [Circle] * count


def test_between_two_pieces_of_cloth_is_neither_chain_nor_quad() -> None:
    points = keys(6, 2).astype(np.float64) * 10
    points[keys(6, 2)[:, 0] > 2, 0] += 40.0
    web = Web(keys(6, 2), points)
    assert sorted(len(chain) for chain in web.chains) == [2] * 6 + [3] * 4
    assert web.quads(np.ones(12, bool)).tolist() == [[0, 1, 7, 6], [1, 2, 8, 7], [3, 4, 10, 9], [4, 5, 11, 10]]
    assert web.quads(np.arange(12) == 1).tolist() == [[1, 2, 8, 7]]
    assert web.quads(np.zeros(12, bool)).shape == (0, 4)


def test_neighbours_are_found_wherever_the_lattice_lies() -> None:
    shuffled = np.random.default_rng(0).permutation(keys(5, 4)) - [7, 2]
    for row, near in enumerate(neighbour_rows(shuffled)):
        for step, other in zip([(1, 0), (0, 1), (-1, 0), (0, -1)], near, strict=True):
            there = (shuffled == shuffled[row] + step).all(axis=1)
            assert other == (there.argmax() if there.any() else -1)
    assert neighbour_rows(keys(1, 1)).tolist() == [[-1, -1, -1, -1]]
    assert neighbour_rows(keys(0, 0)).shape == (0, 4)


def test_the_web_stays_while_lattice_and_picture_do() -> None:
    laid = LatticeVertices(keys(3, 3).astype(float), keys(3, 3) / 4)
    web = web_of(laid, (400, 200))
    assert web_of(laid, (400, 200)) is web
    assert web.step == pytest.approx(75.0)
    assert web_of(laid, (800, 400)).step == pytest.approx(150.0)
    moved = LatticeVertices(laid.keys, laid.places + 0.01)
    assert web_of(moved, (400, 200)) is not web
