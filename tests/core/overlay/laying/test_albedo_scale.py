import numpy as np
import pytest

from core.overlay.laying.albedo_scale import gauge_of


@pytest.mark.parametrize(
    ("light", "brightest", "usual", "white"),
    [
        (2.2, 0.4, 1.0, 0.88),  # bright cloth: the light is the usual one, the texel as bright as it is seen
        (2.2, 0.8, 1.76, 1.0),  # more than white cannot be said of a texel
        (0.5, 0.8, 1.0, 0.4),  # beside something brighter, too
        (0.9, 1.25, 1.125, 1.0),
    ],
)
def test_light_and_texel_share_what_is_seen(light: float, brightest: float, usual: float, white: float) -> None:
    shading = np.full((20, 30), light)
    shading[:5] = np.nan
    texel = np.full((8, 8, 3), brightest)
    gauge = gauge_of(shading, texel)
    assert np.nanmedian(shading) * gauge == pytest.approx(usual)
    assert texel.max() / gauge == pytest.approx(white)


def test_without_cloth_the_texel_stays() -> None:
    assert gauge_of(np.full((4, 4), np.nan), np.full((2, 2, 3), 0.5)) == 1.0
