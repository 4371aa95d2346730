"""Files and pixels that are no image, or that a format cannot hold."""

import os
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from core.arrays import InputError
from core.imaging.images import Image, load, load_mask, save
from tests.core.pictures import picture


def test_what_a_format_cannot_hold_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.webp: cannot be written: "):
        save(picture(height=1, width=20_000), tmp_path / "a.webp")
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match=r"unknown picture format '\.bmp'"):
        save(picture(), tmp_path / "a.bmp")
    with pytest.raises(InputError, match="quality 101: not from 1 to 100"):
        save(picture(), tmp_path / "a.jpg", quality=101)


@pytest.mark.parametrize("suffix", [".png", ".tif", ".exr", ".jpg", ".webp"])
@pytest.mark.parametrize("share", [0.02, 0.5, 0.9])
def test_files_cut_short_are_named(tmp_path: Path, suffix: str, share: float) -> None:
    path = tmp_path / f"a{suffix}"
    save(picture(height=90, width=120), path)
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with pytest.raises(InputError, match=rf"a\{suffix}: .*cut short|a\{suffix}: not an image"):
        load(path)


def test_a_png_is_judged_by_its_critical_chunks(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    save(picture(height=40, width=50), path)
    data = path.read_bytes()
    note = b"tEXt" + b"Comment\0of no weight"
    path.write_bytes(data[:33] + struct.pack(">I", len(note) - 4) + note + bytes(4) + data[33:])
    assert load(path).width_px == 50
    start = data.index(b"IDAT")
    for damaged in (data[: start + 20] + b"!!!!" + data[start + 24 :], data[:-12], data[:-2]):
        path.write_bytes(damaged)
        with pytest.raises(InputError, match=r"a\.png: the image is damaged or cut short"):
            load(path)


def test_a_header_that_asks_for_too_much_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    save(picture(), path)
    data = path.read_bytes()
    header = b"IHDR" + struct.pack(">II", 60_000, 60_000) + data[24:29]
    path.write_bytes(data[:12] + header + struct.pack(">I", zlib.crc32(header)) + data[33:])
    with pytest.raises(InputError, match=r"a\.png: not an image, damaged or cut short"):
        load(path)


def test_what_is_no_image_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("text")
    (tmp_path / "b.png").touch()
    (tmp_path / "a.null").write_text("OpenImageIO takes any file of this name for a black picture")
    os.mkfifo(tmp_path / "pipe")
    for path, fault in {
        "a.png": "not an image",
        "b.png": "the file is empty",
        "c.png": "no such file or directory",
        ".": "is a folder, not an image",
        "pipe": "is a device or a pipe, not a file",
        "a.null": "a.null: not an image of a known format",
    }.items():
        with pytest.raises(InputError, match=fault):
            load(tmp_path / path)


def test_pixels_of_another_kind_are_refused() -> None:
    for pixels in (np.zeros((4, 4), np.uint8), np.zeros((4, 4, 5), np.uint8), np.zeros((4, 4, 3)), np.zeros((0, 4, 3))):
        with pytest.raises(InputError, match="image: pixels of"):
            Image(pixels)


def test_a_mask_of_another_size_is_named(tmp_path: Path) -> None:
    save(picture(channels=1), tmp_path / "mask.png")
    assert load_mask(tmp_path / "mask.png", (7, 5)).shape == (5, 7)
    with pytest.raises(InputError, match=r"mask\.png: the mask has 7x5 pixels, the image 9x5"):
        load_mask(tmp_path / "mask.png", (9, 5))
