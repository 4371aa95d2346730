"""The footprint of a pixel in a texture."""

import numpy as np

from core.overlay.filters.texture_filter import DENSITY, filter_large, filter_texture, footprints

SHAPE = (40, 60)
"""Of the texture."""


def test_a_footprint_has_the_singular_values_and_the_long_axis_of_the_map() -> None:
    rng = np.random.default_rng(0)
    for J in rng.normal(0, 0.04, (60, 2, 2)):
        y, x = np.indices((3, 4))
        at = np.stack([x, y], -1) @ J.T
        along, length, width = footprints(at, np.ones((3, 4), bool), SHAPE)
        samples = np.array(SHAPE[::-1]) / DENSITY
        left, sizes, _ = np.linalg.svd(samples[:, None] * J)
        np.testing.assert_allclose(length, sizes[0], rtol=1e-9)
        np.testing.assert_allclose(width, sizes[1], atol=1e-7)
        axis = left[:, 0] / samples * (1 if length[0] > 1 else 0)
        np.testing.assert_allclose(np.abs(along @ axis), axis @ axis, rtol=1e-6)
        np.testing.assert_allclose(along[:, 0] * axis[1], along[:, 1] * axis[0], atol=1e-9)


def test_a_large_picture_is_filtered_as_a_small_one() -> None:
    texture = np.random.default_rng(1).random((*SHAPE, 3))
    y, x = np.indices((300, 70))
    at = np.stack([x / 55 + np.sin(y / 40), y / 33], -1).astype(np.float32)
    at[100:140, 20:30] = np.nan
    whole = filter_texture(texture, at.astype(float)).astype(np.float32)
    np.testing.assert_array_equal(filter_large(texture, at), whole)
    assert not whole[110, 25].any()
    assert whole[0, 0].any()
