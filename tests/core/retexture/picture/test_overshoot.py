"""A sharp kernel's overshoot is kept where texture needs it, and held beside strong edges."""

import numpy as np
import pytest

from core.arrays import Singles
from core.imaging import color
from core.retexture.picture.overshoot import OVERSHOOT, ColourLimits
from core.retexture.sampling import Kernel, read

SIDE = 32


def between_rows() -> Singles:
    """Return places (SIDE, SIDE, 2) a half and a third of a pixel off the pixels of a source."""
    y, x = np.mgrid[:SIDE, :SIDE].astype(np.float32)
    return np.stack([x + np.float32(0.5), y + np.float32(1 / 3)], axis=-1)


def held(source: Singles, *, linear: bool) -> tuple[Singles, Singles]:
    """Return a source at the places, by the kernel alone and held."""
    at = between_rows()
    sharp = read(source, at, Kernel.LANCZOS, mirror=True).reshape(*at.shape[:2], -1)
    light = sharp.copy()
    ColourLimits(source, linear=linear).hold(light, at)
    return sharp, light


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_rims_beside_a_strong_edge_are_held(channels: int) -> None:
    dark, bright = 0.2, 0.9
    encoded = np.full((SIDE, SIDE, channels), dark, np.float32)
    encoded[:, SIDE // 2 :] = bright
    sharp, light = held(color.decode(encoded), linear=False)
    assert color.encode(sharp).min() < dark - 1.5 * OVERSHOOT
    shown = color.encode(light)
    assert shown.min() == pytest.approx(dark - OVERSHOOT, abs=1e-4)
    assert shown.max() < bright + OVERSHOOT + 1e-4
    even = np.abs(color.encode(sharp) - dark) < OVERSHOOT
    np.testing.assert_array_equal(light[even], sharp[even])


def test_peaks_of_texture_stay() -> None:
    texture = 0.4 + 0.2 * np.random.default_rng(1).random((SIDE, SIDE, 3)).astype(np.float32)
    sharp, light = held(texture, linear=True)
    four = np.stack([texture[i : i + SIDE - 1, j : j + SIDE - 1] for i in (0, 1) for j in (0, 1)])
    assert (sharp[:-1, :-1] < four.min(axis=0) - 0.01).any()
    np.testing.assert_array_equal(light, sharp)


def test_numbers_that_are_no_light_are_held_as_they_are() -> None:
    numbers = np.zeros((SIDE, SIDE, 1), np.float32)
    numbers[:, SIDE // 2 :] = 2.0
    sharp, light = held(numbers, linear=True)
    assert sharp.min() < -1.5 * OVERSHOOT
    assert light.min() == pytest.approx(-OVERSHOOT)
    assert light.max() == pytest.approx(2 + OVERSHOOT)
