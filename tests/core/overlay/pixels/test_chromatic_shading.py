"""The colour of the light over the cloth."""

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.pixels.shading.chromatic_shading import find_tint
from core.overlay.texel import Texel
from tests.core.overlay.overlay_scenes import make_scene, marked_checks

RED = Texel(np.where(marked_checks(mark=False).pixels > 0.55, [0.7, 0.15, 0.16], [0.15, 0.1, 0.12]))
"""Red and dark checks: the red channel has more contrast than the others."""
SCENE = make_scene(RED, bend=0.0)
SIZE = SCENE.shading.shape
ALL = np.ones(SIZE, bool)
MODEL = SCENE.shading[..., None] * RED(SCENE.uv)
ACROSS = np.broadcast_to(np.linspace(-1, 1, SIZE[1]), SIZE)


def lit(amount: float) -> Floats:
    """Return the scene in light that goes from blue to red."""
    return np.asarray(SCENE.photo * np.stack([1 + amount * ACROSS, np.ones(SIZE), 1 - amount * ACROSS], -1))


def test_light_that_changes_colour_is_found() -> None:
    found = find_tint(lit(0.25), MODEL, ALL, 30.0)
    assert found is not None
    ratio = (found[..., 0] / found[..., 2])[:, 30:-30]
    true = ((1 + 0.25 * ACROSS) / (1 - 0.25 * ACROSS))[:, 30:-30]
    assert np.abs(ratio / true - 1).mean() < 0.06
    assert found.mean(-1) == pytest.approx(np.ones(SIZE))


def test_light_of_one_colour_has_no_tint() -> None:
    assert find_tint(SCENE.photo, MODEL, ALL, 30.0) is None
    assert find_tint(SCENE.photo, MODEL, np.zeros(SIZE, bool), 30.0) is None


def test_haze_over_one_side_of_the_cloth_is_no_coloured_light() -> None:
    haze = 0.08 * np.maximum(ACROSS, 0)[..., None]
    assert find_tint(SCENE.photo + haze, MODEL, ALL, 30.0) is None
