import numpy as np

from core.arrays import Bytes
from core.selection.colours import select_alike, select_range


def two_squares() -> Bytes:
    """Return two red squares, the right one a little darker, on blue."""
    picture = np.full((40, 80, 3), (20, 30, 200), np.uint8)
    picture[10:30, 10:30] = (200, 20, 20)
    picture[10:30, 50:70] = (190, 20, 20)
    return picture


def test_the_wand_takes_what_hangs_together_or_all_that_is_alike() -> None:
    near = select_alike(two_squares(), (15, 15), 10, contiguous=True)
    assert near.sum() == 400 * 255
    assert near[20, 20] == 255
    assert select_alike(two_squares(), (15, 15), 10, contiguous=False).sum() == 800 * 255
    assert select_alike(two_squares(), (15, 15), 9, contiguous=False).sum() == 400 * 255
    assert select_alike(two_squares(), (0, 0), 255, contiguous=True).min() == 255


def test_a_range_of_colours_fades_out() -> None:
    ramp = np.zeros((1, 256, 3), np.uint8)
    ramp[0, :, :] = np.arange(256)[:, None]
    mask = select_range(ramp, np.array([[128, 128, 128]], np.uint8), 10.0)[0].astype(int)
    assert mask[128] == 255
    assert mask[0] == mask[255] == 0
    assert set(mask[100:128]) - {0, 255}
    assert (np.diff(mask[:129]) >= 0).all()


def test_several_samples_count_each() -> None:
    picture = two_squares()
    mask = select_range(picture, picture[[15, 0], [15, 0]], 5.0)
    assert mask.min() == 255 or (mask[10:30, 10:30] == 255).all()
    assert (mask[0] == 255).all()
