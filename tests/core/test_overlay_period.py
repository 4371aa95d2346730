"""Telling a texel from its fractions and multiples."""

import numpy as np
import pytest

from core.overlay.period import coarser, estimate_halves, is_period
from tests.core.overlay_scenes import make_scene, marked_checks

HALF = np.array([[0.5, 0.5], [0.5, -0.5]])
"""Steps, in texels, after which checks look alike but for a mark."""


@pytest.mark.parametrize(("mark", "index"), [(True, 2), (False, 1)])
def test_a_mark_in_every_second_check_doubles_the_step(mark: bool, index: int) -> None:
    basis = np.array([[26.0, 2.0], [-1.0, 26.0]])
    scene = make_scene(marked_checks(mark=mark), size=(230, 240), basis=basis, noise=0.03)
    flat = scene.photo / scene.shading[..., None]
    halves = estimate_halves(flat, scene.uv @ np.linalg.inv(HALF).T, np.ones(scene.shading.shape), 2, 0)
    assert round(abs(np.linalg.det(coarser(halves).astype(float)))) == index
    assert is_period(halves, np.array([1.0, 1.0])) or not mark
    assert is_period(halves, np.array([1.0, 0.0])) is not mark
