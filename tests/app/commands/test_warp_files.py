"""Kinds of files that `weft warp` reads and writes."""

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest

from core.imaging.images import Attribute, Image, load, save
from tests.app.commands.warp_scene import HEIGHT, WIDTH, disc, photograph, weft

pytestmark = pytest.mark.gpu


@pytest.mark.parametrize("size", [(1, 1), (1, 5000), (5000, 1)])
def test_thin_pictures_are_warped(folder: Path, size: tuple[int, int]) -> None:
    save(Image(photograph(*size)), "thin.png")
    assert weft("thin.png", "-o", "out.png") == 0
    np.testing.assert_array_equal(load("out.png").pixels, photograph(*size))
    assert weft("thin.png", "-o", "out.png", "--preset", "arc-lower", "--bend=50") == 0


@pytest.mark.parametrize("suffix", [".tif", ".exr", ".webp", ".jpg"])
def test_every_format_is_written(folder: Path, suffix: str) -> None:
    assert weft("photo.png", "-o", f"out{suffix}", "--preset", "wave", "--bend=20") == 0
    assert load(f"out{suffix}").pixels.shape[:2] == (HEIGHT, WIDTH)


def test_depth_and_metadata_go_through(folder: Path) -> None:
    deep = photograph().astype(np.uint16) * 257
    save(Image(deep, metadata=(Attribute("Make", "string", "Weft"),)), "deep.png")
    assert weft("deep.png", "-o", "out.png") == 0
    found = load("out.png")
    assert found.pixels.dtype == np.uint16
    assert np.abs(found.pixels.astype(int) - deep).max() <= 2
    assert ("Make", "Weft") in [(entry.name, entry.value) for entry in found.metadata]


def test_the_same_words_give_the_same_bytes(folder: Path) -> None:
    words = ("photo.png", "--mask", "mask.png", "--preset", "twist", "--bend=60", "-o")
    assert weft(*words, "one.png") == weft(*words, "two.png") == 0
    assert Path("one.png").read_bytes() == Path("two.png").read_bytes()


def write_with(path: str, pixels: Any, **attributes: Any) -> None:
    """Write `pixels` with OpenImageIO itself; colons in names are written as double underscores."""
    kind = {"uint8": "uint8", "float32": "float"}[str(pixels.dtype)]
    spec = OpenImageIO.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    for name, value in attributes.items():
        spec.attribute(name.replace("__", ":"), value)
    buffer = OpenImageIO.ImageBuf(spec)
    buffer.set_pixels(spec.roi, pixels)
    assert buffer.write(path)


BEND = ("--preset", "rise", "--bend", "-40")


def test_numbers_that_are_none_do_not_spread(folder: Path) -> None:
    light = photograph().astype(np.float32) / 255
    light[20, 30] = np.nan
    write_with("light.exr", light)
    assert weft("light.exr", "-o", "out.exr", *BEND) == 0
    assert np.isfinite(load("out.exr").pixels).all()


def test_grey_palette_and_ink_become_pictures(folder: Path) -> None:
    save(Image(disc()[..., None]), "grey.png")
    write_with("palette.gif", photograph())
    write_with("ink.tif", np.concatenate([photograph(), disc(0)[..., None]], axis=2), tiff__ColorSpace="CMYK")
    for name, channels in {"grey.png": 2, "palette.gif": 4, "ink.tif": 4}.items():
        assert weft(name, "-o", "out.png", *BEND) == 0
        assert load("out.png").channels == channels


def test_orientation_is_resolved(folder: Path) -> None:
    write_with("turned.jpg", photograph(), Orientation=6)
    assert weft("turned.jpg", "-o", "out.png") == 0
    assert load("out.png").pixels.shape == (WIDTH, HEIGHT, 3)
