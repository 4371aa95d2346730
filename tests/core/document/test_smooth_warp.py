"""W on large grids while something moves, beside what it is."""

import numpy as np
import pytest

from core.document.document import Document, Pin
from core.document.map import grid_of, preset_of
from core.document.map_solver import MapInputs
from core.document.smooth_warp import SmoothWarp
from core.document.straight_lines import PictureLines
from core.grid import Grid
from core.imaging.image import Image
from core.mapping.tolerances import SEEN_PX
from core.warps.presets import PRESETS, make_warp

GRID = Grid(3000, 2000, cell_px=4.0)
WARP = SmoothWarp(GRID)


@pytest.mark.parametrize("bend", [30.0, -100.0])
@pytest.mark.parametrize("name", PRESETS)
def test_nobody_sees_that_a_preset_is_refined_and_its_outline_is_its_own(name: str, bend: float) -> None:
    warp = make_warp(name, 3000, 2000, bend=bend, horizontal=20.0)
    exact, found = warp(GRID.nodes), WARP.evaluate(warp)
    assert np.linalg.norm(found - exact, axis=-1).max() < SEEN_PX
    assert np.array_equal(found[GRID.outline], exact[GRID.outline])
    assert not np.array_equal(found, exact)


@pytest.mark.parametrize("radius", [20.0, 60.0, 100.0])
def test_where_a_swirl_ends_nodes_are_worked_out_exactly(radius: float) -> None:
    warp = make_warp("swirl", 3000, 2000, bend=100.0, settings={"radius": radius, "center-x": 37.0})
    exact, found = warp(GRID.nodes), WARP.evaluate(warp)
    off = np.linalg.norm(found - exact, axis=-1)
    assert off.max() < SEEN_PX
    assert 0.05 < (off == 0).mean() < 1


def test_what_turns_many_times_is_worked_out_exactly() -> None:
    warp = make_warp("wave", 3000, 2000, bend=100.0, settings={"waves": 8.0})
    assert np.array_equal(WARP.evaluate(warp), warp(GRID.nodes))


def test_a_frame_refines_and_the_answer_at_rest_does_not() -> None:
    start = Document.of(Image(np.zeros((250, 250, 3), np.uint8))).with_warp(preset="arc", bend=40.0, cell_px=1.0)
    inputs = MapInputs(grid_of(start), PictureLines())
    exact, seen = preset_of(start)(grid_of(start).nodes), inputs.plain(start, seen=True)
    assert 0 < np.abs(seen - exact).max() < SEEN_PX
    dragged = start.changed(pins=(Pin((0.5, 0.5), (0.6, 0.5)),))
    assert inputs.plain(dragged, seen=True) is seen
    assert np.array_equal(inputs.plain(dragged), exact)
    assert inputs.plain(dragged, seen=True) is inputs.plain(start)
