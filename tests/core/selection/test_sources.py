import numpy as np
import pytest

from core.arrays import InputError
from core.imaging.images import Image
from core.selection.sources import has_transparency, labels_in, opacity


def test_alpha_is_a_mask_at_every_depth() -> None:
    pixels = np.full((2, 3, 4), 65535, np.uint16)
    pixels[0, 0, 3] = 0
    assert opacity(Image(pixels)).tolist() == [[0, 255, 255], [255, 255, 255]]
    single = np.ones((1, 2, 2), np.float32)
    single[0, 0, 1] = 0.5
    assert opacity(Image(single, linear=True)).tolist() == [[128, 255]]


@pytest.mark.parametrize("pixels", [np.zeros((2, 2, 3), np.uint8), np.full((2, 2, 4), 255, np.uint8)])
def test_a_picture_that_is_opaque_has_no_mask(pixels: np.ndarray) -> None:
    assert not has_transparency(Image(pixels))
    with pytest.raises(InputError, match="no transparency"):
        opacity(Image(pixels))


def test_small_numbers_are_labels() -> None:
    found = labels_in(np.array([[0, 3, 3, 17]], np.uint8))
    assert found is not None
    assert found.tolist() == [[0, 1, 1, 2]]


@pytest.mark.parametrize("mask", [np.zeros((2, 2)), np.full((2, 2), 100), np.array([[0, 255]]), np.arange(100)[None]])
def test_masks_and_ramps_are_no_labels(mask: np.ndarray) -> None:
    assert labels_in(mask.astype(np.uint8)) is None
