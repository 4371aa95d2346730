"""Light is encoded and decoded exactly, and alpha goes in and out."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from core.arrays import Bytes, Singles
from core.imaging import color

UNIT = st.floats(0, 1, width=32)
PIXELS = arrays(np.float32, (3, 4), elements=UNIT)


def singles(values: object) -> Singles:
    return np.array(values, np.float32)


def octets(values: object) -> Bytes:
    return np.array(values, np.uint8)


def test_known_values() -> None:
    encoded = singles([0, 0.04045, 0.5, 1])
    np.testing.assert_allclose(color.decode(encoded), [0, 0.0031308, 0.2140411, 1], rtol=1e-4)


def test_the_two_pieces_meet() -> None:
    around = singles([0.04045, np.nextafter(np.float32(0.04045), np.float32(1))])
    assert abs(np.diff(color.decode(around))[0]) < 1e-7


@given(arrays(np.float32, 8, elements=st.floats(-2, 20, width=32)))
def test_encoding_undoes_decoding(values: Singles) -> None:
    np.testing.assert_allclose(color.encode(color.decode(values)), values, atol=2e-5, rtol=2e-5)


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_every_level_comes_back(depth: Any) -> None:
    levels = np.arange(np.iinfo(depth).max + 1, dtype=depth).reshape(-1, 1)
    light = color.linear_light(levels, linear=False)
    np.testing.assert_array_equal(color.store(light, depth=depth, linear=False), levels)
    assert (np.diff(light[:, 0]) > 0).all()


def test_alpha_is_not_light() -> None:
    light = color.linear_light(octets([[128, 128, 128, 128]]), linear=False)
    np.testing.assert_allclose(light, [[0.2158605, 0.2158605, 0.2158605, 128 / 255]], rtol=1e-5)
    np.testing.assert_array_equal(color.store(light, depth=np.uint8, linear=False), [[128] * 4])


@given(PIXELS)
def test_premultiplying_is_undone(pixels: Singles) -> None:
    pixels[:, 3] = np.maximum(pixels[:, 3], np.float32(1e-3))
    np.testing.assert_allclose(color.unpremultiply(color.premultiply(pixels)), pixels, rtol=1e-5, atol=1e-6)


def test_without_alpha_there_is_no_color() -> None:
    np.testing.assert_array_equal(color.unpremultiply(singles([[0.5, 0.5, 0.5, 0]])), [[0, 0, 0, 0]])


def test_over_a_backdrop() -> None:
    np.testing.assert_allclose(color.over(singles([[0.2, 0.4, 0.6, 0.5]]), 1.0), [[0.6, 0.7, 0.8]])
    opaque = singles([[0.2, 0.4, 0.6]])
    assert color.over(opaque, 1.0) is opaque


def test_quantising_rounds_and_clips() -> None:
    values = singles([-1, 0.4999 / 255, 0.5001 / 255, 1, 7])
    np.testing.assert_array_equal(color.quantise(values, np.uint8), [0, 0, 1, 255, 255])


@pytest.mark.parametrize("depth", ["u1", "u2", "f4"])
@pytest.mark.parametrize("numbers", [[0], [0, 3], [0, 1, 2], [3]])
def test_channels_are_taken_as_an_index_takes_them(depth: str, numbers: list[int]) -> None:
    pixels = np.arange(5 * 7 * 4).reshape(5, 7, 4).astype(depth)
    taken = color.take_channels(pixels[:, 1:6], numbers)
    assert taken.dtype == pixels.dtype
    assert np.array_equal(taken, pixels[:, 1:6][..., numbers])
