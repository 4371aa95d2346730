"""What the editor shows of a retexture besides the picture."""

from dataclasses import replace

import numpy as np
import pytest

from core.arrays import Bytes
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.retexture import debug_views as overlays
from core.retexture.job import retexture
from core.retexture.result import Retexture


def deformed() -> Retexture:
    """Return the plain deformation of a small picture."""
    pixels: Bytes = np.random.default_rng(1).integers(0, 255, (60, 80, 3), np.uint8)
    line = np.linspace((10, 30), (70, 30), 4)
    plain = next(retexture(pixels, [FeatureCurve(Curve(line), Curve(line + [0, 6]))])).preview
    assert isinstance(plain, Retexture)
    return plain


@pytest.mark.parametrize(("pressed", "shown"), [(1.0, 0), (np.sqrt(3), 128), (3.0, 255)])
def test_the_compression_is_shown_by_its_logarithm(pressed: float, shown: int) -> None:
    plain = deformed()
    field = np.full((plain.grid.rows, plain.grid.columns), pressed)
    assert np.abs(overlays.compression(replace(plain, compression=field)).astype(int) - shown).max() <= 1


def test_without_patches_there_are_no_seams_and_no_grids() -> None:
    plain = deformed()
    assert not overlays.seams(plain).any()
    assert not overlays.compression(plain).any()
    assert len(overlays.visible_origins(plain)[0]) == 0
