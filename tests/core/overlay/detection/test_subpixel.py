"""The vertex of the paraboloid through a maximum and its neighbours."""

import numpy as np
import pytest

from core.overlay.detection.subpixel import find_vertices

Y, X = np.mgrid[:7, :9].astype(np.float32)


def vertex_at(surface: np.ndarray, x: int, y: int) -> np.ndarray:
    """Return what is found of the 3 x 3 values around a place; beyond the surface nothing is known."""
    around = np.pad(surface.astype(np.float32), 1, constant_values=np.nan)
    return find_vertices(around[y : y + 3, x : x + 3].reshape(1, 9))


@pytest.mark.parametrize("mixed", [0.0, 0.9, -1.1])
@pytest.mark.parametrize("vertex", [(4.0, 3.0), (4.3, 2.8), (3.6, 3.4)])
def test_the_vertex_of_a_slanting_paraboloid_is_found(mixed: float, vertex: tuple[float, float]) -> None:
    x, y = X - vertex[0], Y - vertex[1]
    surface = 1 - 0.5 * x**2 - 0.8 * y**2 - mixed * x * y
    found = vertex_at(surface, 4, 3)
    assert found == pytest.approx(np.array([vertex]) - [4, 3], abs=1e-4)


@pytest.mark.parametrize("place", [(0, 3), (8, 3), (4, 0), (4, 6)])
def test_at_the_edge_a_maximum_stays_where_it_is(place: tuple[int, int]) -> None:
    surface = -((X - place[0] - 0.2) ** 2) - (Y - place[1] + 0.2) ** 2
    assert not vertex_at(surface, *place).any()


def test_beside_what_is_unknown_a_maximum_stays_where_it_is() -> None:
    surface = -((X - 4.2) ** 2) - (Y - 3.2) ** 2
    assert vertex_at(surface, 4, 3).all()
    surface[2, 5] = np.nan
    assert not vertex_at(surface, 4, 3).any()


@pytest.mark.parametrize("surface", [X * 0, X * Y, (X - 4) ** 2 + (Y - 3) ** 2, -((X - 5.5) ** 2) - (Y - 3) ** 2])
def test_what_has_no_maximum_within_a_pixel_stays_where_it_is(surface: np.ndarray) -> None:
    assert not vertex_at(surface, 4, 3).any()
