"""Which texel cloth shows: the mean of what is registered, and what most show of anything else."""

from dataclasses import replace

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.registration import cloth as cloth_module
from core.overlay.registration.cloth import Fit, FittedCloth, estimate, measure
from core.overlay.registration.evidence import weigh
from core.overlay.registration.fitting import refit
from core.overlay.texel import estimate_texel
from tests.core.overlay.pixels.test_filling import SCENE, SIZE, straight

SPOT = 0.3
"""By how much the middle of a texel is brighter where it has a spot."""


@pytest.fixture(scope="module")
def spotted() -> tuple[FittedCloth, Fit, float]:
    """Return cloth of which some texels have a spot in the middle, its fit, and the share of those that have."""
    columns = np.floor(SCENE.uv[..., 0])
    has_spot, middle = (columns % 5 == 1) | (columns % 5 == 3), (np.abs(SCENE.uv % 1 - 0.5) < 0.1).all(-1)
    even = SCENE.photo / SCENE.shading[..., None]
    cloth, whole = straight(even + SPOT * (has_spot & middle)[..., None], np.ones(SIZE, bool))
    piece = replace(whole, rho=np.ones_like(whole.rho))
    return cloth, measure(cloth, estimate(cloth, (piece,)), (piece,)), float(has_spot[middle].mean())


def middle_of(cloth: FittedCloth, found: Fit, *, by_mean: bool) -> Floats:
    """Return the colour in the middle of the texel that a fit shows."""
    return estimate(cloth, found.pieces, by_mean=by_mean).at(np.array([[0.5, 0.5]]))


def test_it_is_the_mean_once_the_cloth_is_registered(spotted: tuple[FittedCloth, Fit, float]) -> None:
    cloth, found, share = spotted
    most, mean = (middle_of(cloth, found, by_mean=by_mean) for by_mean in (False, True))
    np.testing.assert_allclose(mean - most, share * SPOT, atol=0.02)
    registered = refit(cloth, found, rounds=1)
    shown = estimate(cloth, registered.pieces, by_mean=True)
    np.testing.assert_array_equal(registered.texel.pixels, shown.pixels)


def test_what_cloth_may_miss_is_told_by_what_most_texels_show(spotted: tuple[FittedCloth, Fit, float]) -> None:
    cloth, found, _ = spotted
    registered = refit(cloth, found, rounds=1)
    by_most = measure(cloth, estimate(cloth, registered.pieces), registered.pieces)
    by_mean = measure(cloth, registered.texel, registered.pieces)
    assert registered.tolerance == by_most.tolerance != by_mean.tolerance


def test_of_a_plaid_it_is_what_most_texels_show(spotted: tuple[FittedCloth, Fit, float]) -> None:
    cloth, found, _ = spotted
    plaid = replace(cloth, is_woven=True)
    same = [middle_of(plaid, found, by_mean=by_mean) for by_mean in (False, True)]
    np.testing.assert_array_equal(same[0], same[1])


def test_a_find_is_weighed_by_the_mean(
    spotted: tuple[FittedCloth, Fit, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    cloth, found, _ = spotted
    by_mean = weigh(cloth, found).share
    monkeypatch.setattr(cloth_module, "estimate_texel", lambda *given, **_: estimate_texel(*given))
    assert by_mean > weigh(cloth, found).share
