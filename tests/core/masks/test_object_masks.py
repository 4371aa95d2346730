import cv2
import numpy as np
import pytest

from core.arrays import Bytes, InputError
from core.imaging.images import Image
from core.masks.object_masks import object_under, whole_object
from core.progress import run


def shape(radius_px: int, *, size: tuple[int, int] = (300, 200)) -> Bytes:
    """Return a disc with a bar through it, as a mask."""
    mask = np.zeros((size[1], size[0]), np.uint8)
    cv2.circle(mask, (150, 100), radius_px, (255,), -1)
    cv2.line(mask, (88, 100), (212, 100), (255,), max(radius_px // 3, 1))
    return mask


def picture_of(mask: Bytes, *, dtype: type = np.uint8) -> Image:
    noise = np.random.default_rng(1).normal(0, 18, (*mask.shape, 3))
    colours = np.where(mask[..., None] > 0, (200, 170, 60), (70, 90, 110)) + noise
    values = np.clip(colours, 0, 255)
    return Image((values / 255).astype(np.float32), linear=True) if dtype == np.float32 else Image(values.astype(dtype))


def overlap(found: Bytes, mask: Bytes) -> float:
    inside, wanted = found > 127, mask > 0
    return float((inside & wanted).sum() / (inside | wanted).sum())


@pytest.mark.parametrize("paint_px", [-12, 7])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_paint_that_stops_short_or_goes_beyond_is_fitted(paint_px: int, dtype: type) -> None:
    mask = shape(50)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * abs(paint_px) + 1,) * 2)
    rough = np.asarray(cv2.dilate(mask, kernel) if paint_px > 0 else cv2.erode(mask, kernel), np.uint8)
    assert overlap(rough, mask) < 0.75
    assert overlap(run(object_under(picture_of(mask, dtype=dtype), rough)), mask) > 0.95


def test_what_looks_alike_elsewhere_is_left_alone() -> None:
    mask = shape(30)
    both = mask.copy()
    cv2.circle(both, (40, 30), 14, (255,), -1)
    found = run(object_under(picture_of(both), mask))
    assert overlap(found, mask) > 0.95
    assert not found[:50, :60].any()


def test_whole_object_grows_out_of_a_part_of_it() -> None:
    mask = np.zeros((200, 300), np.uint8)
    cv2.rectangle(mask, (20, 60), (270, 140), (255,), -1)
    cv2.circle(mask, (290, 20), 8, (255,), -1)
    known = np.zeros((200, 300), bool)
    known[75:130, 120:160] = True
    found = run(whole_object(picture_of(mask), known))
    wanted = mask > 0
    wanted[:40, 280:] = False
    assert (found & wanted).sum() / (found | wanted).sum() > 0.95


def test_object_that_is_known_as_a_whole_is_refused() -> None:
    mask = shape(50)
    with pytest.raises(InputError, match="no more stands out"):
        run(whole_object(picture_of(mask), mask > 0))
    with pytest.raises(InputError, match="no more stands out"):
        run(whole_object(picture_of(mask), np.ones(mask.shape, bool)))


def test_large_pictures_are_fitted_at_their_own_size() -> None:
    small = shape(50)
    size = (1500, 1000)
    large = np.asarray(cv2.resize(small, size, interpolation=cv2.INTER_NEAREST), np.uint8)
    rough = np.asarray(cv2.dilate(large, np.ones((41, 41), np.uint8)), np.uint8)
    found = run(object_under(picture_of(large), rough))
    assert found.shape == (1000, 1500)
    assert overlap(found, large) > 0.95


@pytest.mark.parametrize("value", [0, 255])
def test_nothing_painted_and_everything_painted_are_refused(value: int) -> None:
    mask = shape(50)
    with pytest.raises(InputError, match="paint"):
        run(object_under(picture_of(mask), np.full_like(mask, value)))


def test_one_pixel_in_a_picture_of_one_colour_is_no_fault() -> None:
    rough = np.zeros((40, 40), np.uint8)
    rough[20, 20] = 255
    found = run(object_under(Image(np.full((40, 40, 3), 90, np.uint8)), rough))
    assert found.shape == rough.shape


def test_specks_of_the_other_colour_are_neither_parts_nor_holes() -> None:
    mask = shape(50)
    seen = mask.copy()
    for x, y in ((130, 80), (160, 120), (95, 80), (205, 115)):
        cv2.circle(seen, (x, y), 2, (255 - int(mask[y, x]),), -1)
    found = run(object_under(picture_of(seen), mask)) > 127
    assert [cv2.connectedComponents(side.astype(np.uint8))[0] - 1 for side in (found, ~found)] == [1, 1]


def test_paint_on_what_goes_on_around_it_is_refused() -> None:
    rough = np.zeros((200, 300), np.uint8)
    cv2.circle(rough, (150, 100), 40, (255,), -1)
    with pytest.raises(InputError, match="around it"):
        run(object_under(picture_of(np.zeros_like(rough)), rough))
