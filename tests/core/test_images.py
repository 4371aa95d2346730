"""Pictures come back from disk as they were written, and faults are named in one line."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.arrays import InputError
from core.images import Image, load, load_mask, save


def picture(depth: Any = np.uint8, channels: int = 3, height: int = 5, width: int = 7) -> Image:
    values = np.random.default_rng(0).uniform(0.1, 1, (height, width, channels))
    if depth is np.float32:
        return Image(values.astype(np.float32), linear=True)
    return Image((values * np.iinfo(depth).max).astype(depth))


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize(
    ("depth", "suffix"), [(np.uint8, ".png"), (np.uint16, ".png"), (np.uint8, ".tif"), (np.uint16, ".tiff")]
)
def test_integers_come_back_as_they_were(tmp_path: Path, depth: Any, channels: int, suffix: str) -> None:
    image = picture(depth, channels)
    save(image, tmp_path / f"a{suffix}")
    back = load(tmp_path / f"a{suffix}")
    assert back.pixels.dtype == depth
    assert not back.linear
    np.testing.assert_array_equal(back.pixels, image.pixels)


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize("suffix", [".exr", ".tif"])
def test_floats_come_back_as_they_were(tmp_path: Path, channels: int, suffix: str) -> None:
    image = picture(np.float32, channels)
    save(image, tmp_path / f"a{suffix}")
    back = load(tmp_path / f"a{suffix}")
    assert back.linear
    np.testing.assert_allclose(back.pixels, image.pixels, rtol=1e-6)


def test_a_mask_of_another_size_is_named(tmp_path: Path) -> None:
    save(picture(channels=1), tmp_path / "mask.png")
    assert load_mask(tmp_path / "mask.png", (5, 7)).shape == (5, 7)
    with pytest.raises(InputError, match=r"mask\.png: the mask has 7x5 pixels, the image 9x5"):
        load_mask(tmp_path / "mask.png", (5, 9))
