"""What is said of a picture that is read as a mask."""

import numpy as np
import pytest

from core.arrays import Bytes
from core.imaging.images import Image, mask_of
from core.masks.mask_files import describe_mask, marks_of, marks_or_opacity_of

NOTHING = "The mask marks nothing: {}, and only what is over 127 is marked."


def said(pixels: Bytes) -> str:
    image = Image(pixels)
    return describe_mask(image, mask_of(image, "mask.png", image.size_px))


def grey(values: object) -> Bytes:
    return np.resize(np.array(values, np.uint8), (10, 10, 1))


@pytest.mark.parametrize(
    ("pixels", "text"),
    [
        (grey(0), NOTHING.format("all of it is 0")),
        (grey(range(100)), NOTHING.format("its brightest pixel is 99")),
        (grey(255), "The mask marks the whole picture."),
        (grey([255, 0, 0, 0]), "The mask marks 25 % of the picture."),
    ],
)  # fmt: skip
def test_a_mask_is_put_into_words(pixels: Bytes, text: str) -> None:
    assert said(pixels) == text


def test_transparency_is_said_not_to_count() -> None:
    pixels = np.full((10, 10, 4), 255, np.uint8)
    assert said(pixels) == "The mask marks the whole picture."
    pixels = pixels.copy()
    pixels[:5, :, 3] = 0
    assert said(pixels) == "The mask marks the whole picture. Its transparency does not count, only how bright it is."


def test_labels_are_numbered_in_order() -> None:
    mask, numbers, text = marks_of(Image(grey([0, 5, 9])), grey([0, 5, 9])[..., 0])
    assert text == "The mask holds 2 labels, each of them a feature."
    assert numbers is not None
    assert numbers[0, :4].tolist() == [0, 1, 2, 0]
    assert mask[0, :4].tolist() == [0, 255, 255, 0]


def test_of_a_picture_of_one_grey_the_opacity_counts() -> None:
    pixels = np.full((10, 10, 4), 255, np.uint8)
    pixels[:5, :, 3] = 0
    mask, numbers, text = marks_or_opacity_of(Image(pixels), pixels[..., 0])
    assert numbers is None
    assert np.array_equal(mask, pixels[..., 3])
    assert text == "The mask marks 50 % of the picture: what is opaque."
    assert marks_or_opacity_of(Image(pixels), grey([0, 255])[..., 0])[0].mean() < 128
