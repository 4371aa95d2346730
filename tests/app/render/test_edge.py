"""Which cells the outline may cut pixels of."""

import numpy as np

from app.render.passes.mesh import EDGE_PX, find_edge
from core.linalg.cubic_convolution import Complexes

ROWS, COLUMNS = 41, 61


def grid() -> Complexes:
    """Return nodes 8 pixels apart."""
    x, y = np.meshgrid(np.arange(COLUMNS) * 8.0, np.arange(ROWS) * 8.0)
    return np.asarray(x + 1j * y)


def test_of_cells_as_thick_as_a_pixel_the_outermost_count() -> None:
    found = find_edge(grid(), EDGE_PX)
    assert found.shape == (ROWS + 1, COLUMNS + 1)
    assert not found[2:-2, 2:-2].any()
    found[2:-2, 2:-2] = True
    assert found.all()


def test_where_cells_are_thin_further_ones_count_and_nowhere_else() -> None:
    z, rows = grid(), slice(18, 23)
    z.real[rows, :6] = 0.2 * np.arange(6)
    further = find_edge(z, EDGE_PX)[2:-2, 2:-2]
    assert further[16:20, :5].all()
    assert not further[:14].any()
    assert not further[22:].any()
    assert not further[:, 8:].any()


def test_where_cells_are_slanted_their_height_counts() -> None:
    z = grid()
    z.imag[1:4] = 0.2 * np.arange(1, 4)[:, None]
    z.real[1:4] += 30
    assert find_edge(z, EDGE_PX)[1:5, 1:-1].all()
