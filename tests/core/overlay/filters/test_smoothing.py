"""A picture in which motifs outweigh their ground."""

import cv2
import numpy as np
import pytest

from core.arrays import Singles
from core.overlay.filters.smoothing import LIGHT_PX, shrink_ground

SIZE = 240, 240
ALL = np.ones(SIZE, np.bool_)


def uneven_ground() -> Singles:
    """Return folds (H, W, 1) of a standard deviation of 0.08."""
    waves = cv2.GaussianBlur(np.random.default_rng(0).standard_normal(SIZE), (0, 0), 3.0)
    return np.asarray(0.08 * waves[..., None] / waves.std(), np.float32)


def correlation(a: Singles, b: Singles) -> float:
    return float(np.corrcoef(a.ravel(), b.ravel())[0, 1])


def test_patches_of_a_motif_on_uneven_ground_are_more_alike_once_the_ground_is_shrunk() -> None:
    image = np.ones((*SIZE, 3), np.float32) + uneven_ground()
    places = [(60, 60), (60, 180), (180, 60), (180, 180)]
    for x, y in places:
        cv2.circle(image, (x, y), 4, (1.5, 1.4, 1.2), -1)
    before, after = (
        [plane[y - 20 : y + 21, x - 20 : x + 21] for x, y in places]
        for plane in (image, shrink_ground(image, ALL, LIGHT_PX))
    )
    alike = [[correlation(patches[0], other) for other in patches[1:]] for patches in (before, after)]
    assert max(alike[0]) < 0.65
    assert (np.subtract(alike[1], alike[0]) > 0.07).all()


def test_checks_stay_as_they_are_but_for_their_contrast() -> None:
    y, x = np.indices(SIZE)
    checks = np.where((x // 12 + y // 12) % 2, 0.8, 1.2)[..., None] * np.ones(3, np.float32)
    shrunk = shrink_ground(checks.astype(np.float32), ALL, LIGHT_PX)
    assert correlation(checks[40:-40, 40:-40], shrunk[40:-40, 40:-40]) > 0.95


@pytest.mark.parametrize("is_any", [True, False])
def test_an_even_picture_stays_even_and_nothing_is_seen_outside(is_any: bool) -> None:
    valid = np.zeros(SIZE, np.bool_)
    valid[40:200, 50:190] = is_any
    even = np.where(valid[..., None], np.float32(1), np.float32(0)) * np.ones(3, np.float32)
    assert np.allclose(shrink_ground(even, valid, LIGHT_PX), even, atol=1e-3)
