"""Sketches of an edited grid: near the exact answer, and exact where that is a similarity."""

import numpy as np
import pytest

from core.curves import Curve
from core.grid import Grid
from core.mapping.editing import Frame, edit_grid
from core.mapping.handles import Handles
from core.mapping.sketch import Sketch

GRID = Grid(320, 260, cell_px=2.5)
SOURCE = np.array([[60.0, 80.0], [120.0, 40.0], [160.0, 160.0], [230.0, 120.0]])


def handles(target: np.ndarray) -> Handles:
    return Handles(np.empty((0, 2)), np.empty((0, 2)), [(Curve(SOURCE), Curve(target))])


def test_a_similarity_is_sketched_exactly() -> None:
    turn = np.array([[0.9, 0.3], [-0.3, 0.9]])
    found = Sketch(GRID, frame="free").solve(handles(SOURCE @ turn + [12.0, -30.0]), GRID.nodes)
    assert np.abs(found - (GRID.nodes @ turn + [12.0, -30.0])).max() < 1e-3


@pytest.mark.parametrize("frame", ["free", "held"])
def test_a_sketch_is_near_the_exact_answer(frame: Frame) -> None:
    bent = SOURCE + [[4.0, 16.0], [0.0, 26.0], [20.0, -12.0], [-16.0, 8.0]]
    base = GRID.nodes * [1.1, 0.9]
    exact = edit_grid(GRID, handles(bent), base=base, frame=frame)
    found = Sketch(GRID, frame=frame).solve(handles(bent), base)
    apart = np.hypot(*np.moveaxis(found - exact, -1, 0))
    assert np.hypot(*np.moveaxis(exact - base, -1, 0)).max() > 20
    assert apart.mean() < 0.7
    assert apart.max() < 2.5
