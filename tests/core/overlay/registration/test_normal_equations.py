"""The registration's equations have a solution whatever pixels say, though they are summed in single precision."""

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.mesh import ClothMesh
from core.overlay.registration.normal_equations import SYMMETRIC, Smoothness, System


@pytest.mark.parametrize("directions", [1, 2])
@pytest.mark.parametrize("said", [0.4, 0.1, 0.01])
def test_pixels_that_say_little_in_some_directions_leave_a_solution(said: float, directions: int) -> None:
    """Stripes say nothing along them, and some pixels say a million times as much as others."""
    random = np.random.default_rng(0)
    mesh = ClothMesh((160, 160), 8)
    cells = np.ones(mesh.cells, np.bool_)
    system = System(mesh, cells, np.ones(mesh.nodes, np.bool_))
    shape = cells.sum(), mesh.cell**2
    moments = np.zeros((len(SYMMETRIC), *shape), np.float32)
    for _ in range(directions):
        along = random.normal(size=3) * (1, 1, 1000)
        strength = random.random(shape) * 10 ** random.uniform(-6, 3, (len(moments[0]), 1))
        strength[random.random(len(strength)) > said] = 0
        for out, (i, j) in zip(moments, SYMMETRIC, strict=True):
            out += strength.astype(np.float32) * np.float32(along[i]) * np.float32(along[j])
    gradient = np.ones((3, *shape), np.float32)
    step = system.solve(moments, gradient, np.zeros((3, len(system.around))), Smoothness(), np.eye(3))
    assert np.isfinite(step).all()


def test_variables_are_changed_after_the_sums_as_before_them() -> None:
    random = np.random.default_rng(1)
    mesh = ClothMesh((48, 40), 8)
    cells = np.ones(mesh.cells, np.bool_)
    system = System(mesh, cells, np.ones(mesh.nodes, np.bool_))
    change = np.array([[0.05, 0.01, 0.0], [-0.02, 0.04, 0.0], [0.0, 0.0, 1.0]])
    slopes, missing = random.normal(size=(3, cells.sum(), 64)), random.normal(size=(cells.sum(), 64))
    theta = random.normal(size=(3, len(system.around)))

    def step(slopes: Floats, change: Floats) -> Floats:
        moments = np.array([slopes[i] * slopes[j] for i, j in SYMMETRIC], np.float32)
        return system.solve(moments, (slopes * missing).astype(np.float32), theta, Smoothness(), change)

    changed = np.einsum("ki,k...->i...", change, slopes)
    assert np.allclose(step(slopes, change), step(changed, np.eye(3)), rtol=1e-3, atol=1e-3)
