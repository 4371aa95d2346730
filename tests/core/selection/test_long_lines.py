import cv2
import numpy as np
import pytest

from core.imaging.images import Image
from core.selection.long_lines import are_long, find_lines, lengths_of, long_lines_within


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
    found = find_lines(scene(scale))
    lines = found[are_long(found, (500 * scale, 300 * scale))] / scale
    horizon, *mast = lines
    assert horizon[:, 1] == pytest.approx([139.5, 139.5], abs=1.0)
    assert np.ptp(horizon[:, 0]) > 480
    assert len(mast) == 2
    for line in mast:
        ends = line[np.argsort(line[:, 1])]
        assert ends == pytest.approx(np.array([[100.0, 20.0], [130.0, 130.0]]), abs=6.0)


def test_a_picture_of_one_colour_has_none() -> None:
    assert find_lines(Image(np.full((40, 60, 1), 9, np.uint8))).shape == (0, 2, 2)
    assert find_lines(Image(np.full((1, 1, 4), 9, np.uint8))).shape == (0, 2, 2)


@pytest.mark.parametrize("step", [1, 2])
def test_within_a_part_of_the_picture_lines_are_cut_and_what_is_long_in_it_counts(step: int) -> None:
    lines = find_lines(scene())
    area = np.zeros((300, 500), bool)
    area[40:160, 290:350] = True
    found = long_lines_within(lines, area[::step, ::step], (500, 300))
    assert len(lines[are_long(lines, (500, 300))]) == 3
    assert found[0, :, 1] == pytest.approx([139.5, 139.5], abs=1.0)
    assert np.sort(found[0, :, 0]) == pytest.approx([290, 349], abs=1 + step)
    strokes = found[1:]
    assert len(strokes) == 2
    assert strokes[..., 1] == pytest.approx(np.full((2, 2), 60), abs=4)
    assert lengths_of(strokes) == pytest.approx([20, 20], abs=5)
    assert long_lines_within(lines, np.zeros((300, 500), bool), (500, 300)).shape == (0, 2, 2)


def test_a_part_in_pieces_has_a_line_for_each() -> None:
    area = np.zeros((300, 500), bool)
    area[100:200, :150] = area[100:200, 300:] = True
    across = [np.sort(line[:, 0]) for line in long_lines_within(find_lines(scene()), area, (500, 300))]
    horizon = sorted(ends.tolist() for ends in across if np.ptp(ends) > 100)
    assert np.array(horizon) == pytest.approx(np.array([[0, 149], [300, 499]]), abs=2)
