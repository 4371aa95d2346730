"""The plate that goes on through gaps, and tears where that is less."""

import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.pixels.gaps.weak_plate import Plate

SIZE = (40, 60)
Y, X = np.indices(SIZE).astype(float)
PLANE = np.stack([1.1 * X + 0.1 * Y, 0.9 * Y - 0.2 * X], -1)
SLOPES = np.broadcast_to(np.array([[0.1, 1.1], [0.9, -0.2]]), (*SIZE, 2, 2)).copy()


def laid(places: Floats, free: Bools, most: float = 2.0) -> tuple[Floats, Bools]:
    """Return the places with those of the free pixels found, and which pixels are beside a tear."""
    out, torn = places.copy(), np.zeros(SIZE, bool)
    out[free] = Plate(places, ~free, free, SLOPES).weakened(most)
    for here, there, slope in ((np.s_[:-1], np.s_[1:], (0.1, 0.9)), (np.s_[:, :-1], np.s_[:, 1:], (1.1, -0.2))):
        strained = np.linalg.norm(out[there] - out[here] - slope, axis=-1) > 1.5
        torn[here] |= strained
        torn[there] |= strained
    return out, torn


def test_a_plane_goes_on() -> None:
    free = (X > 30) | (Y > 30)
    out, torn = laid(np.where(free[..., None], np.nan, PLANE), free)
    np.testing.assert_allclose(out, PLANE, atol=1e-4)
    assert not torn.any()


@pytest.mark.parametrize(("miss", "width", "tears"), [(3.0, 20, False), (30.0, 8, True)])
def test_sides_meet_over_a_wide_gap_and_jump_over_a_narrow_one(miss: float, width: float, tears: bool) -> None:
    free = np.abs(X - 30) < width / 2
    missed = PLANE + np.where(X > 30, miss, 0.0)[..., None] * [1.0, 0.0]
    out, torn = laid(missed, free)
    assert torn.any() == tears
    stretch = np.diff(out[..., 0], axis=1) - 1.1
    if tears:
        assert (torn.sum(1) <= 3).all()
        assert np.abs(stretch)[~torn[:, 1:] | ~torn[:, :-1]].max() < 0.3
    else:
        assert np.abs(stretch).max() < 3 * miss / width


def test_a_jump_runs_where_it_is_shortest() -> None:
    """The gap between two sides that miss each other narrows to two pixels, along a line that is ragged above."""
    ragged = np.abs(X - 30) < 8 + 4 * np.sin(Y)
    missed = PLANE + np.where(X > 30, 12.0, 0.0)[..., None] * [1.0, 0.0]
    out, _ = laid(missed, ragged)
    place = np.abs(np.diff(out[..., 0], axis=1) - 1.1).argmax(1)
    assert np.abs(np.diff(place)).max() <= 1
    assert np.ptp(place) <= 4
