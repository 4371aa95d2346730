"""OBJ meshes say where the picture's places go."""

import numpy as np

from core.canvas import Canvas
from core.grid import Grid
from core.interchange.obj import obj_mesh


def rows(text: str, kind: str) -> list[list[str]]:
    return [line.split()[1:] for line in text.splitlines() if line.startswith(f"{kind} ")]


def test_the_undeformed_grid_covers_picture_and_texture_alike() -> None:
    grid = Grid(40, 20, cell_px=5)
    text = obj_mesh(grid.nodes, grid.nodes, (40, 20), Canvas(40, 20))
    places, shares = (np.array(rows(text, kind), float) for kind in ("v", "vt"))
    assert np.allclose(places[:, :2] / (40, 20), shares, atol=1e-6)
    assert np.allclose(places.min(axis=0), 0)
    assert np.allclose(places.max(axis=0), (40, 20, 0))
    assert np.allclose(shares[0], (0, 1))


def test_faces_are_the_quads_turning_counter_clockwise() -> None:
    grid = Grid(40, 20, cell_px=5)
    shifted = grid.nodes * 2 + (3, 4)
    text = obj_mesh(grid.nodes, shifted, (40, 20), Canvas(90, 60))
    places = np.array(rows(text, "v"), float)[:, :2]
    faces = [[corner.split("/") for corner in face] for face in rows(text, "f")]
    assert all(place == share for face in faces for place, share in face)
    corners = places[np.array(faces)[..., 0].astype(int) - 1]
    assert len(corners) == (grid.rows - 1) * (grid.columns - 1)
    x, y = corners[..., 0], corners[..., 1]
    areas = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1) / 2
    assert np.allclose(areas, 100)
    assert np.allclose(places[0], shifted[0, 0] * (1, -1) + (0.5, 59.5))
