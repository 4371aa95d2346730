"""Reading a picture between its pixels."""

import numpy as np
import pytest

from core.arrays import Points
from core.retexture.sampling import Kernel, read


@pytest.mark.parametrize("kernel", list(Kernel))
def test_reading_at_pixels_returns_them(kernel: Kernel) -> None:
    picture = np.random.default_rng(1).random((30, 40, 3)).astype(np.float32)
    y, x = np.mgrid[5:20, 5:30]
    at: Points = np.stack([x, y], axis=-1).astype(np.float64)
    np.testing.assert_allclose(read(picture, at, kernel), picture[5:20, 5:30], atol=1e-5)
    np.testing.assert_allclose(
        read(picture, at.reshape(1, 1, -1, 2), kernel)[0, 0], picture[5:20, 5:30].reshape(-1, 3), atol=1e-5
    )
    assert read(picture, np.empty((0, 2)), kernel).shape == (0, 3)
