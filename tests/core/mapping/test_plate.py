"""The plate of handles: its energy, its responses, its Poisson solve."""

import numpy as np
import pytest
from scipy import sparse

from core.grid import Grid
from core.mapping.features.similarity import fit_residual
from core.mapping.handles.dirichlet_plate import HeldPlate
from core.mapping.handles.plate import HandleField, make_plate
from core.mapping.handles.probes import Probes
from core.mapping.jacobians import Complexes, as_complex
from tests.core.mapping.test_handles import GRID


@pytest.mark.parametrize("size", [(120, 90), (24, 300), (90, 9), (9, 9), (6, 200)])
def test_a_held_plate_bends_as_little_as_the_handles_allow(size: tuple[int, int]) -> None:
    """The plate's answer has the gradient of E at nodes that no handle holds, within the outline: zero."""
    grid = Grid(*size, cell_px=3)
    at = np.array([[0.4, 0.5], [0.7, 0.3], [0.71, 0.33]]) * size
    field = HandleField(grid, make_plate(grid, "held"), Probes.of_points(at))
    d = field.displace(as_complex(np.array([[4.0, 1.0], [-2.0, 3.0], [-2.5, 3.0]])))
    unit = np.sqrt(np.prod(grid.cell))
    width, height = grid.cell / unit

    def sides(z: Complexes) -> Complexes:
        padded = np.pad(z, 1)
        x = (2 * z - padded[1:-1, :-2] - padded[1:-1, 2:]) / width**2
        return np.asarray(x + (2 * z - padded[:-2, 1:-1] - padded[2:, 1:-1]) / height**2)

    inner = d[1:-1, 1:-1]
    length = 0.1 * np.hypot(*grid.shape)
    forces = np.zeros(grid.shape, np.complex128)
    forces[1:-1, 1:-1] = sides(inner) + length**2 * sides(sides(inner))
    at_handles = np.zeros(grid.size, bool)
    margin = np.minimum(grid.cell, np.array(size) / 2)
    at_handles[grid.weights_at(np.clip(at, margin - 0.5, size - margin - 0.5))[0]] = True
    loose = ~at_handles.reshape(grid.shape)
    assert np.abs(forces).max() > 0.01
    assert np.abs(forces[loose]).max() < 1e-9 * np.abs(forces).max()


def test_an_unknown_motion_of_the_plate_leaves_no_force_on_a_body() -> None:
    rim = np.array([[150.0, 80.0], [190, 80], [170, 60], [170, 100]])
    at = np.concatenate([[[60.0, 60.0]], rim])
    Q = np.zeros((5, 3), np.complex128)
    Q[1:, 0], Q[1:, 1], Q[1:, 2] = 1j * as_complex(rim - rim.mean(axis=0)), 1, 1j
    field = HandleField(GRID, make_plate(GRID, "held"), Probes.of_points(at), bodies=sparse.csr_array(Q))
    known = np.array([20.0 + 5j, 0, 0, 0, 0])
    found = known + Q @ field.find_motions(known, np.ones(3, np.complex128))
    d = field.displace(found)
    assert np.abs(field.at_points(d) - found).max() < 1e-9
    assert fit_residual(as_complex(rim), as_complex(rim) + field.at_points(d)[1:], rigid=False) < 1e-12
    assert abs(found[1:].mean()) > 0.1
    assert d.shape == GRID.shape


def test_responses_are_what_the_answers_have_at_the_places() -> None:
    grid = Grid(300, 170, cell_px=7)
    at = np.random.default_rng(3).uniform(8, 160, (9, 2))
    held = HeldPlate(grid, smoothness=0.1).hold(at)
    nodes, weights = grid.weights_at(at)
    for force, row in zip(np.eye(9, dtype=np.complex128), held.S, strict=True):
        assert np.abs((held.answer(force)[nodes] * weights).sum(axis=1) - row).max() < 1e-12 * held.S.max()


def test_the_fast_poisson_solve_has_its_load() -> None:
    plate = HeldPlate(GRID, smoothness=0.1)
    load = np.zeros(GRID.shape, np.complex128)
    load[20, 13], load[5, 40] = 1 + 2j, -3j
    y = plate.solve_poisson(load)
    padded = np.pad(y, 1)
    inner = 2 * (4 * y - padded[1:-1, :-2] - padded[1:-1, 2:] - padded[:-2, 1:-1] - padded[2:, 1:-1])
    assert np.abs(y[GRID.outline]).max() == 0
    assert np.abs((inner - load)[1:-1, 1:-1]).max() < 1e-12
