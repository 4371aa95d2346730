"""A plate with fewer nodes than the picture's grid, refined by cubics."""

import cv2
import numpy as np
import pytest
import scipy

from core.arrays import Bytes, Points
from core.grid import Grid, find_features
from core.linalg.cubic_convolution import CubicConvolution, Smooth
from core.mapping.handles import dirichlet_plate
from core.mapping.handles.handles import Handles
from core.mapping.handles.plate import Frame
from core.mapping.jacobians import as_complex
from core.mapping.options import MappingOptions
from core.mapping.warper import Warper
from tests.core.mapping.test_handles import moved, places

SIZE = 602, 402
GRID = Grid(*SIZE, cell_px=4)
PINS = np.array([[120.0, 80.0], [420.0, 300.0], [300.0, 200.0]])
SHIFTS = np.array([[20.0, 6.0], [-15.0, 8.0], [4.0, -18.0]])


def painted() -> Bytes:
    found = np.zeros(SIZE[::-1], np.uint8)
    cv2.circle(found, (300, 200), 50, 255, -1)
    cv2.circle(found, (10, 210), 40, 255, -1)
    return found


def test_what_is_at_most_quadratic_is_refined_exactly() -> None:
    coarse, fine = Grid(100, 60, cell_px=10), Grid(100, 60, cell_px=3)
    x, y = coarse.nodes[..., 0], coarse.nodes[..., 1]
    d = (x * y + 3 * x - 1) + 1j * (x * x - 2 * y)
    u, v = fine.nodes[..., 0], fine.nodes[..., 1]
    away = CubicConvolution(coarse.shape, fine.shape).refine(d) - ((u * v + 3 * u - 1) + 1j * (u * u - 2 * v))
    inner = (u > coarse.cell[0]) & (u < 99 - coarse.cell[0])  # beyond the ends it goes on straight
    assert np.abs(away[inner]).max() < 1e-9
    assert np.abs(away).max() < coarse.cell[0] ** 2 / 4


def test_some_nodes_are_read_as_all_are_refined() -> None:
    coarse, fine = Grid(100, 60, cell_px=10), Grid(100, 60, cell_px=3)
    d = np.random.default_rng(3).normal(size=(*coarse.shape, 2)).view(np.complex128)[..., 0]
    field = Smooth(d, CubicConvolution(coarse.shape, fine.shape))
    nodes = np.arange(fine.size).reshape(-1, 2)
    assert np.abs(field.read(nodes).ravel() - field.whole.ravel()).max() < 1e-12
    sums = scipy.sparse.csr_array(np.random.default_rng(4).normal(size=(3, 50)) + 1j)
    for one in (field, Smooth(field.whole)):
        assert np.abs(one.combine(sums, np.arange(50)) - np.asarray(sums @ field.whole.ravel()[:50])).max() < 1e-12
    assert np.array_equal(Smooth(field.whole).read(nodes).ravel(), field.whole.ravel())


def test_a_plate_with_fewer_nodes_gives_the_same_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    handles = Handles(PINS, PINS + SHIFTS)
    whole = moved(handles, painted=painted(), grid=GRID)
    monkeypatch.setattr(dirichlet_plate, "DEFAULT_NODES_AT_MOST", GRID.size // 5)
    found = moved(handles, painted=painted(), grid=GRID)
    assert 1e-4 < np.abs(found.warped - whole.warped).max() < 1.0
    assert np.abs(places(found, PINS, GRID) - (PINS + SHIFTS)).max() < 1e-5
    assert np.abs(found.warped[GRID.outline] - GRID.nodes[GRID.outline]).max() < 1e-9
    assert not found.folded.any()


def test_the_frame_slides_exactly_by_what_moves_on_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """A pin on the frame and one in a feature that the frame cuts."""
    at = np.array([[200.0, -0.5], [20.0, 210.0]])
    to: Points = at + [[31.0, 0.0], [0.0, 25.0]]
    whole = moved(Handles(at, to), painted=painted(), grid=GRID)
    monkeypatch.setattr(dirichlet_plate, "DEFAULT_NODES_AT_MOST", GRID.size // 5)
    found = moved(Handles(at, to), painted=painted(), grid=GRID)
    assert np.abs(places(found, at, GRID) - to).max() < 0.1
    assert np.abs(whole.warped - GRID.nodes)[GRID.outline].max() > 20
    assert np.abs(found.warped - whole.warped)[GRID.outline].max() < 1e-9
    assert 1e-4 < np.abs(found.warped - whole.warped).max() < 1.0
    assert not found.folded.any()
    frame = as_complex(found.warped)
    # What follows the frame leaves no step behind it.
    bend = np.abs(frame[:-2] - 2 * frame[1:-1] + frame[2:])[:, 1:-1]
    assert bend[0].max() < 0.5


def test_the_frame_may_be_let_go_in_the_midst_of_a_drag(monkeypatch: pytest.MonkeyPatch) -> None:
    """The free plate has other nodes than the held one: nothing of the one goes on in the other."""
    monkeypatch.setattr(dirichlet_plate, "DEFAULT_NODES_AT_MOST", GRID.size // 5)
    live, features = Warper(GRID), find_features(GRID, painted())
    shown = {}
    steps: list[Frame] = ["held", "held", "free", "free", "held"]
    for step, frame in enumerate(steps):
        live.use(features, MappingOptions(frame=frame))
        shown[frame] = live.frame(GRID.nodes, Handles(PINS, PINS + SHIFTS * (step + 1) / 5))
        assert np.abs(places(shown[frame], PINS, GRID) - PINS - SHIFTS * (step + 1) / 5).max() < 0.1
    assert np.abs(shown["held"].warped - GRID.nodes)[GRID.outline].max() < 1e-9
    assert np.abs(shown["free"].warped - GRID.nodes)[GRID.outline].max() > 1
