"""Where several pixels of the source fall on one of the result, it shows their mean; elsewhere nothing is lost."""

import numpy as np
import pytest

from core.arrays import Ints, Singles
from core.retexture.picture.area_filter import average, boxes
from core.retexture.sampling import Kernel, read

SIDE = 24
WHOLE: Ints = np.ones((SIDE, SIDE), np.int32)


def linear(right: tuple[float, float], down: tuple[float, float]) -> Singles:
    """Return the places (SIDE, SIDE, 2) of a map by its steps, about the middle of a source four times as wide."""
    y, x = np.mgrid[:SIDE, :SIDE].astype(np.float32)[..., None] - SIDE / 2
    return np.asarray(2 * SIDE + x * np.array(right) + y * np.array(down), np.float32)


def test_what_is_turned_or_stretched_is_not_filtered() -> None:
    turned = linear((0.8, 0.6), (-0.6, 0.8))
    stretched = linear((0.3, 0.0), (0.0, 1.0))
    for place in (turned, stretched):
        assert not len(boxes(place, WHOLE).pixel)


@pytest.mark.parametrize("turn", np.radians([0, 35, 90, 140, 215, 300]))
def test_a_box_spreads_as_the_image_of_a_pixel_does(turn: float) -> None:
    along, aside = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    # In a map that turns by an angle, and presses by 3 along the turned x; the other way it stretches.
    right, down = (
        3 * along * np.cos(0.4) + 0.5 * aside * np.sin(0.4),
        -3 * along * np.sin(0.4) + 0.5 * aside * np.cos(0.4),
    )
    found = boxes(linear(tuple(right), tuple(down)), WHOLE)
    assert len(found.pixel) == SIDE**2
    whole = found.halves[:, :, 0] - found.halves[:, :, 1]
    sides = np.linalg.norm(whole, axis=-1)
    np.testing.assert_allclose(np.sort(sides / 2, axis=1), [[0, np.sqrt(8)]] * SIDE**2, atol=1e-4)
    longer = whole[np.arange(SIDE**2), sides.argmax(axis=1)] / 2
    np.testing.assert_allclose(np.abs(longer @ along), np.sqrt(8), atol=1e-4)


def test_each_half_of_a_side_keeps_to_its_side_of_a_crease() -> None:
    place = linear((1.0, 0.0), (0.0, 1.0))
    place[:, 12:, 0] += 3 * np.arange(SIDE - 12, dtype=np.float32)
    found = boxes(place, WHOLE)
    crease = found.pixel % SIDE == 12
    assert crease.sum() == SIDE
    reach = np.sort(np.abs(found.halves[crease, :, :, 0]).max(axis=1), axis=1)
    np.testing.assert_allclose(reach, [[0, np.sqrt(15)]] * SIDE, atol=1e-4)


def test_no_box_reaches_across_a_seam_or_lies_in_the_plain_deformation() -> None:
    place, label = linear((1.0, 0.0), (0.0, 1.0)), WHOLE.copy()
    place[:, 12:] += 7
    assert len(boxes(place, label).pixel)
    label[:, 12:] = 2
    assert not len(boxes(place, label).pixel)
    assert not len(boxes(linear((3.0, 0.0), (0.0, 1.0)), 0 * WHOLE).pixel)


def test_a_thin_line_that_is_pressed_together_stays_a_whole_line() -> None:
    source = np.zeros((4 * SIDE, 4 * SIDE, 1), np.float32)
    x = np.arange(4 * SIDE)
    source[x, np.clip(x // 2 + SIDE, 0, 4 * SIDE - 1)] = 1
    place = linear((3.0, 0.0), (0.0, 1.0))
    dotted = read(source, place, Kernel.LANCZOS, mirror=True).reshape(SIDE, SIDE, 1)
    whole = dotted.copy()
    average(whole, source, place, boxes(place, WHOLE))
    # Every row crosses the line once: a third of its light is there, wherever it lies between the pixels.
    np.testing.assert_allclose(whole.sum(axis=(1, 2)), 1 / 3, atol=0.08)
    assert dotted.sum(axis=(1, 2)).std() > 3 * whole.sum(axis=(1, 2)).std()
