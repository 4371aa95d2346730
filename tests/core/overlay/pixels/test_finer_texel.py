"""The texel as it is told in the end, at the resolution of the photo."""

from dataclasses import replace

import numpy as np

from core.overlay.pixels.model import begin
from core.overlay.pixels.stages import estimate_finer_texel, paint_pieces
from core.overlay.registration.cloth import estimate, measure
from tests.core.overlay.pixels.test_filling import SCENE, SIZE, straight


def test_it_is_the_mean_of_what_texels_show_where_they_differ() -> None:
    cloth, whole = straight(SCENE.photo, np.ones(SIZE, bool))
    third = np.floor(SCENE.uv[..., 0]) % 3 == 0
    middle = (np.abs(SCENE.uv % 1 - 0.5) < 0.1).all(-1)
    colours = []
    for photo in (SCENE.photo, SCENE.photo + 0.3 * (third & middle)[..., None]):
        piece = replace(whole, rho=np.ones_like(whole.rho))
        found = measure(cloth, estimate(cloth, (piece,)), (piece,))
        model = paint_pieces(begin(cloth, found, photo, np.ones(SIZE, bool), is_told=True))
        texel = estimate_finer_texel(replace(model, followed=np.isfinite(model.shading))).texel
        colours.append(texel.at(np.array([[0.5, 0.5]])))
    share = third[middle].mean()
    np.testing.assert_allclose(colours[1] - colours[0], 0.3 * share, atol=0.03)
