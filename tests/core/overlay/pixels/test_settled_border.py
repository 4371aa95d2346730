"""Cloth that was carried straight on to its border, registered there."""

from dataclasses import replace

import numpy as np

from core.overlay.pixels.model import begin
from core.overlay.pixels.stages import paint_pieces, settle_border
from core.overlay.registration.cloth import estimate, measure
from core.overlay.registration.registration import ClothState
from tests.core.overlay.pixels.test_filling import SCENE, SIZE, straight

OFF = 0.15
"""Texels by which cloth that went straight on lies beside the photo."""


def test_border_is_registered_where_the_mesh_can_go_on_and_the_rest_stays() -> None:
    cloth, whole = straight(SCENE.photo, np.ones(SIZE, bool))
    cells = np.zeros(cloth.mesh.cells, bool)
    cells[:, :8] = True
    piece = ClothState(whole.uv, whole.rho, cells)
    found = measure(cloth, estimate(cloth, (piece,)), (piece,))
    model = paint_pieces(begin(cloth, found, SCENE.photo, np.ones(SIZE, bool), is_told=True))
    covered = model.inside
    columns, true = np.indices(SIZE)[1], cloth.mesh.to_pixels(whole.uv, np.ones(cloth.mesh.cells, bool))
    wanted = ~covered & (columns < 11 * cloth.mesh.cell)
    uv = np.where(wanted[..., None], true + OFF, model.uv).astype(np.float32)
    shading = np.where(wanted, 1.0, model.shading).astype(np.float32)
    border = settle_border(replace(model, uv=uv, shading=shading), wanted, covered)
    away = np.linalg.norm(border.uv - true, axis=-1)[wanted]
    assert np.isfinite(away).all()
    assert np.percentile(away, 90) < OFF / 4
    np.testing.assert_array_equal(border.uv[covered], uv[covered])
    np.testing.assert_array_equal(border.inside, covered | wanted)
