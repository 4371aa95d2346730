import cv2
import numpy as np
import pytest

from core.imaging.images import Image
from core.selection.long_lines import find_long_lines


def scene(scale: int = 1) -> Image:
    """Return a horizon, a slanted mast, a short stroke, and a black border."""
    pixels = np.full((300 * scale, 500 * scale, 3), (190, 210, 230), np.uint8)
    pixels[140 * scale :] = (40, 90, 60)
    cv2.line(pixels, (100 * scale, 20 * scale), (130 * scale, 130 * scale), (20, 20, 20), 4 * scale)
    cv2.line(pixels, (300 * scale, 60 * scale), (320 * scale, 60 * scale), (20, 20, 20), 4 * scale)
    pixels[: 2 * scale] = pixels[-2 * scale :] = 0
    return Image(pixels)


@pytest.mark.parametrize("scale", [1, 3])
def test_the_horizon_and_the_mast_are_found_and_nothing_else(scale: int) -> None:
    lines = find_long_lines(scene(scale)) / scale
    horizon, *mast = lines
    assert horizon[:, 1] == pytest.approx([139.5, 139.5], abs=1.0)
    assert np.ptp(horizon[:, 0]) > 480
    assert len(mast) == 2
    for line in mast:
        ends = line[np.argsort(line[:, 1])]
        assert ends == pytest.approx(np.array([[100.0, 20.0], [130.0, 130.0]]), abs=6.0)


def test_a_picture_of_one_colour_has_none() -> None:
    assert find_long_lines(Image(np.full((40, 60, 1), 9, np.uint8))).shape == (0, 2, 2)
    assert find_long_lines(Image(np.full((1, 1, 4), 9, np.uint8))).shape == (0, 2, 2)
