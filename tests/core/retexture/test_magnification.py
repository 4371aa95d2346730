"""How much is magnified, in bands along the curves."""

import numpy as np
import pytest

from core.arrays import Singles
from core.curves.feature_curves import FeatureCurve
from core.retexture.job import deform
from core.retexture.magnification import BAND_PX, BANDS, bands, distance, find_magnified
from tests.core.retexture.retexture_scenes import HEIGHT, WIDTH, bent, straight


def identity() -> Singles:
    y, x = np.mgrid[:40, :50]
    return np.stack([x, y], axis=-1).astype(np.float32)


@pytest.mark.parametrize(("scale", "is_magnified"), [(1.5, False), (1.7, True)])
@pytest.mark.parametrize("axis", [0, 1])
def test_what_is_drawn_out_in_any_direction_is_magnified(scale: float, *, is_magnified: bool, axis: int) -> None:
    place, label = identity(), np.zeros((40, 50), np.int64)
    place[..., axis] /= scale
    turned = place @ np.array([[0.8, 0.6], [-0.6, 0.8]], np.float32)
    for shown in (place, turned):
        assert find_magnified(shown, label)[5:35, 5:45].all() == is_magnified
        assert find_magnified(shown, label)[5:35, 5:45].any() == is_magnified


def test_a_seam_is_not_magnified_and_what_is_pressed_together_is_not() -> None:
    place, label = identity(), np.zeros((40, 50), np.int64)
    place[:, 25:] -= 0.9
    label[:, 25:] = 1
    assert not find_magnified(place, label).any()
    assert find_magnified(place, np.zeros_like(label)).any()
    assert not find_magnified(3 * identity(), np.zeros_like(label)).any()


def test_distances_are_those_from_the_nearest_curve() -> None:
    away = distance([straight(100.0), straight(20.0)], (HEIGHT, WIDTH))
    np.testing.assert_allclose(away[[100, 90, 60, 25], 110], [0, 10, 40, 5], atol=0.5)
    assert distance([straight(-50.0)], (HEIGHT, WIDTH)).min() >= BAND_PX * BANDS


def test_bands_compare_what_is_shown_with_the_plain_deformation() -> None:
    curves: list[FeatureCurve] = bent()
    plain = deform((HEIGHT, WIDTH), curves, None)
    targets = [curve.target for curve in curves if curve.target is not None]
    found = bands(plain, targets)
    assert [(band.from_px, band.to_px) for band in found] == [(10 * i, 10 * i + 10) for i in range(len(found))]
    assert all(band.regrown == band.plain for band in found)
    assert max(band.plain for band in found) > 0.02
    plain.place[...] = 0
    assert all(band.regrown == pytest.approx(1, abs=0.1) for band in bands(plain, targets)[:4])
