import cv2
import numpy as np
import pytest

from core.arrays import InputError
from core.imaging.images import Image
from core.progress import run
from core.selection.objects import object_in_box


def test_an_object_is_found_whole_and_without_specks() -> None:
    rng = np.random.default_rng(3)
    pixels = rng.normal((60, 90, 150), 5, (300, 400, 3))
    inside = np.zeros((300, 400), np.uint8)
    cv2.circle(inside, (200, 150), 60, (1,), -1)
    pixels[inside > 0] = rng.normal((210, 120, 40), 5, (int(inside.sum()), 3))
    pixels[140:150, 195:205] = (60, 90, 150)
    pixels[60:63, 110:113] = (210, 120, 40)
    image = Image(np.clip(pixels, 0, 255).astype(np.uint8))
    mask = run(object_in_box(image, np.array([100.0, 50.0]), np.array([300.0, 250.0]))) > 127
    assert (mask & (inside > 0)).sum() / (mask | (inside > 0)).sum() > 0.97
    assert cv2.connectedComponents(mask.astype(np.uint8))[0] == 2


def test_noise_is_no_object() -> None:
    image = Image(np.random.default_rng(0).integers(0, 255, (300, 400, 3)).astype(np.uint8))
    with pytest.raises(InputError, match="paint over"):
        run(object_in_box(image, np.array([100.0, 50.0]), np.array([300.0, 250.0])))
