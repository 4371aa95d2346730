"""JPEG XL in and out: every depth and every channel, bit by bit at quality 100."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.imaging.images import Image, load, save
from tests.core.profiles import icc_profile


@pytest.mark.parametrize("depth", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_quality_100_keeps_every_sample(tmp_path: Path, depth: Any, channels: int) -> None:
    drawn = np.random.default_rng(0).random((33, 45, channels), np.float32)
    pixels = drawn if depth == np.float32 else (drawn * np.iinfo(depth).max).astype(depth)
    save(Image(pixels, linear=depth == np.float32), tmp_path / "a.jxl", quality=100)
    back = load(tmp_path / "a.jxl")
    kept = [0, 0, 0, 1] if channels == 2 else range(channels)
    np.testing.assert_array_equal(back.pixels, pixels[..., kept])
    assert back.linear == (depth == np.float32)


def test_less_quality_is_smaller_and_close(tmp_path: Path) -> None:
    y, x = np.mgrid[0:64, 0:64]
    grain = np.random.default_rng(0).normal(0, 6, (64, 64, 1))
    drawn = (np.stack([40 + x * 2, 40 + y * 2, 128 + 60 * np.sin(x / 9)], axis=-1) + grain).astype(np.uint8)
    for quality in (100, 80):
        save(Image(drawn), tmp_path / f"{quality}.jxl", quality=quality)
    assert (tmp_path / "80.jxl").stat().st_size < (tmp_path / "100.jxl").stat().st_size / 2
    assert 0 < np.abs(load(tmp_path / "80.jxl").pixels.astype(int) - drawn).mean() < 6


def test_the_profile_is_kept(tmp_path: Path) -> None:
    profile = icc_profile()
    save(Image(np.full((8, 8, 3), 90, np.uint8), icc=profile), tmp_path / "a.jxl", quality=100)
    assert load(tmp_path / "a.jxl").icc == profile
