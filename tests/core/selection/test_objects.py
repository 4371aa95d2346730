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


@pytest.mark.parametrize("low", [(-20.0, -20.0), (0.0, 0.0)])
def test_a_box_that_holds_all_of_the_sky_does_not_take_it(low: tuple[float, float]) -> None:
    rng = np.random.default_rng(5)
    pixels = rng.normal((120, 170, 230), 5, (300, 400, 3))
    pixels[160:] = rng.normal((200, 180, 130), 5, (140, 400, 3))
    inside = np.zeros((300, 400), np.uint8)
    cv2.ellipse(inside, (200, 90), (90, 50), 0, 0, 360, (1,), -1)
    pixels[inside > 0] = rng.normal((190, 50, 40), 5, (int(inside.sum()), 3))
    image = Image(np.clip(pixels, 0, 255).astype(np.uint8))
    mask = run(object_in_box(image, np.array(low), np.array([420.0, 158.0]))) > 127
    assert (mask & (inside > 0)).sum() / (mask | (inside > 0)).sum() > 0.97


def test_a_box_around_all_of_the_picture_finds_what_stands_out_in_it() -> None:
    rng = np.random.default_rng(6)
    pixels = rng.normal((90, 110, 90), 8, (300, 400, 3))
    inside = np.zeros((300, 400), np.uint8)
    cv2.rectangle(inside, (150, 100), (250, 299), (1,), -1)  # the border cuts it
    pixels[inside > 0] = rng.normal((200, 190, 60), 8, (int(inside.sum()), 3))
    image = Image(np.clip(pixels, 0, 255).astype(np.uint8))
    mask = run(object_in_box(image, np.array([-5.0, -5.0]), np.array([410.0, 310.0]))) > 127
    assert (mask & (inside > 0)).sum() / (mask | (inside > 0)).sum() > 0.97


def test_an_object_that_the_border_cuts_at_three_sides_is_found() -> None:
    rng = np.random.default_rng(7)
    pixels = rng.normal((110, 140, 220), 8, (300, 400, 3))
    pixels[120:] = rng.normal((200, 130, 50), 8, (180, 400, 3))
    image = Image(np.clip(pixels, 0, 255).astype(np.uint8))
    mask = run(object_in_box(image, np.array([-9.0, 100.0]), np.array([409.0, 309.0]))) > 127
    assert mask[125:].mean() > 0.97
    assert mask[:115].mean() < 0.01


def test_a_narrow_box_along_the_border_is_answered() -> None:
    rng = np.random.default_rng(8)
    image = Image(np.clip(rng.normal((110, 140, 220), 8, (300, 400, 3)), 0, 255).astype(np.uint8))
    with pytest.raises(InputError):
        run(object_in_box(image, np.array([50.0, -9.0]), np.array([350.0, 8.0])))
