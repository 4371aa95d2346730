"""What is worked on in the box of the cloth alone comes out as on all of the photo."""

from collections.abc import Callable

import numpy as np
import pytest

from core.overlay.pixels import stages
from core.overlay.pixels.model import PixelModel, begin
from core.overlay.pixels.stages import cut_occluders, find_border, paint_pieces, refine_pixels
from core.overlay.registration.cloth import estimate, measure
from core.overlay.registration.registration import ClothState
from tests.core.overlay.pixels.test_filling import SCENE, SIZE, straight

ALL = 10**6
"""Widths around the cloth that hold all of the photo."""
Y, X = np.indices(SIZE)
CLOTH = (abs(Y - SIZE[0] / 2) < SIZE[0] / 4) & (abs(X - SIZE[1] / 2) < SIZE[1] / 4)
BUTTON = np.hypot(Y - SIZE[0] / 2, X - SIZE[1] * 0.26) < 7


@pytest.fixture(scope="module")
def model() -> PixelModel:
    """Return cloth amid a photo, a button at its edge, as the mesh lays it: a little too small, and a little off."""
    noise = np.random.default_rng(1).normal(0, 0.02, (*SIZE, 3))
    photo = np.where(CLOTH[..., None], SCENE.photo, np.array([0.1, 0.3, 0.1]) + noise)
    photo[BUTTON] = 0.9, 0.1, 0.6
    cloth, whole = straight(photo, np.ones(SIZE, bool))
    cells = np.asarray(cloth.mesh.cell_means(CLOTH.astype(float)) == 1, np.bool_)
    piece = ClothState(whole.uv + 0.01, whole.rho, cells)
    found = measure(cloth, estimate(cloth, (piece,)), (piece,))
    return paint_pieces(begin(cloth, found, photo, np.ones(SIZE, bool), is_told=True))


@pytest.mark.parametrize("stage", [find_border, cut_occluders, refine_pixels])
def test_what_is_further_from_the_cloth_changes_nothing(
    model: PixelModel, stage: Callable[[PixelModel], PixelModel], monkeypatch: pytest.MonkeyPatch
) -> None:
    near = stage(model)
    monkeypatch.setattr(stages, "AROUND", ALL)
    whole = stage(model)
    np.testing.assert_array_equal(near.inside, whole.inside)
    np.testing.assert_array_equal(near.hidden, whole.hidden)
    np.testing.assert_allclose(near.uv, whole.uv, atol=1e-5)
    is_changed = (whole.inside != model.inside).any() or whole.hidden.any() or (abs(whole.uv - model.uv) > 1e-3).any()
    assert is_changed
