import cv2
import numpy as np
import pytest

from core.arrays import Bools, Bytes, InputError
from core.imaging.images import Image
from core.masks.object_masks import object_under
from core.progress import run
from core.selection.importance import importance, propose
from core.selection.salient_object import common_colours, find_salient_object, middle, share_of_border


def banner(size: tuple[int, int] = (300, 200)) -> Bytes:
    """Return the mask of an object that reaches from the upper to the lower border."""
    mask = np.zeros((200, 300), np.uint8)
    mask[:, 90:211] = 255
    return np.asarray(cv2.resize(mask, size, interpolation=cv2.INTER_NEAREST))


def shirt() -> Bytes:
    """Return the mask of an object that nearly fills the lower two thirds of a picture."""
    mask = np.zeros((200, 300), np.uint8)
    mask[70:, 5:295] = 255
    return mask


def on_a_rug(mask: Bytes, patch_px: int) -> Image:
    """Return a picture of an object of one colour on ground of patches of three colours."""
    rng, (height, width) = np.random.default_rng(1), mask.shape
    patches = rng.integers(0, 3, (height // patch_px + 1, width // patch_px + 1))
    ground = np.array([(190, 150, 110), (90, 60, 40), (60, 90, 60)])[
        patches.repeat(patch_px, 0).repeat(patch_px, 1)[:height, :width]
    ]
    colours = np.where(mask[..., None] > 0, (150, 130, 150), ground) + rng.normal(0, 6, (height, width, 3))
    return Image(np.clip(colours, 0, 255).astype(np.uint8))


def overlap(found: Bools, mask: Bytes) -> float:
    wanted = mask > 0
    return float((found & wanted).sum() / (found | wanted).sum())


@pytest.mark.parametrize(("patch_px", "by_ground"), [(10, 0.5), (25, 0.5), (50, 0.85)])
def test_an_object_that_reaches_the_border_is_found_by_its_middle(patch_px: int, by_ground: float) -> None:
    mask = banner()
    image = on_a_rug(mask, patch_px)
    important = propose(run(importance(image)), 0.4, image.size_px)
    assert overlap(run(object_under(image, important, may_be_far=True)) > 127, mask) < by_ground
    assert overlap(run(find_salient_object(image)), mask) > 0.93


def test_ground_of_two_colours_is_all_told_from_the_object_by_the_border() -> None:
    mask = shirt()
    y, x = np.mgrid[:200, :300]
    ground = np.where((y < 35)[..., None], (90, 110, 140), (180, 170, 160))
    checks = np.where(((x // 10 + y // 10) % 2)[..., None] > 0, (200, 60, 120), (230, 200, 80))
    noise = np.random.default_rng(1).normal(0, 12, (200, 300, 3))
    image = Image(np.clip(np.where(mask[..., None] > 0, checks, ground) + noise, 0, 255).astype(np.uint8))
    with_floor = run(object_under(image, middle(image.size_px), may_be_far=True)) > 127
    assert overlap(with_floor, mask) < 0.8
    assert common_colours(image.pixels, with_floor) < 0.01
    assert overlap(run(find_salient_object(image)), mask) > 0.95


def test_a_large_picture_is_looked_at_made_smaller_and_has_a_mask_of_its_size() -> None:
    mask = banner((600, 400))
    found = run(find_salient_object(on_a_rug(mask, 50)))
    assert found.shape == mask.shape
    assert overlap(found, mask) > 0.95


def test_where_nothing_stands_out_there_is_no_object() -> None:
    with pytest.raises(InputError, match="no object stands out from its ground"):
        run(find_salient_object(Image(np.full((40, 60, 3), 90, np.uint8))))


@pytest.mark.parametrize("size", [(1, 1), (1, 400), (400, 1), (3, 7)])
def test_a_picture_of_any_size_is_looked_at(size: tuple[int, int]) -> None:
    with pytest.raises(InputError):
        run(find_salient_object(Image(np.full((size[1], size[0], 3), 90, np.uint8))))


def test_colours_that_an_object_has_in_common_with_its_ground_are_counted() -> None:
    mask = shirt()
    pixels = on_a_rug(mask, 20).pixels
    assert common_colours(pixels, mask > 0) < 0.1
    assert common_colours(pixels, np.tile(np.arange(300) < 150, (200, 1))) > 0.7


def test_the_share_of_the_border_inside_is_measured() -> None:
    assert share_of_border(shirt() > 0) == pytest.approx(290 / 1000)
    assert share_of_border(banner() > 0) == pytest.approx(242 / 1000)


def test_the_middle_is_a_quarter_of_the_picture() -> None:
    inside = middle((300, 200)) > 0
    assert inside.mean() == pytest.approx(0.25, abs=0.005)
    np.testing.assert_array_equal(inside, inside[::-1, ::-1])
    assert inside[100, 100:200].all()
    assert not inside[:20].any()
