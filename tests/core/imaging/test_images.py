"""Pictures come back from disk as they were written."""

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest

from core.arrays import Bytes, InputError, Singles
from core.imaging import color
from core.imaging import reading as image_reading
from core.imaging import writing as image_writing
from core.imaging.images import Attribute, Image, load, load_mask, save, writing_rows
from tests.core.pictures import picture
from tests.core.profiles import icc_profile

EXIF = (
    Attribute("Make", "string", "Acme"),
    Attribute("ExposureTime", "float", 0.008),
    Attribute("Exif:Flash", "uint16", 16),
    Attribute("Exif:FocalLength", "float", 50.0),
    Attribute("Exif:DateTimeOriginal", "string", "2020:01:01 00:00:00"),
    Attribute("GPS:Latitude", "float[3]", (52.0, 30.0, 12.25)),
)


def singles(values: object) -> Singles:
    return np.array(values, np.float32)


def octets(values: object) -> Bytes:
    return np.array(values, np.uint8)


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


def write_with(path: Path, pixels: Any, **attributes: Any) -> None:
    """Write `pixels` with OpenImageIO itself; colons in names are written as double underscores."""
    kinds = {"uint8": "uint8", "uint16": "uint16", "float32": "float"}
    spec = OpenImageIO.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kinds[str(pixels.dtype)])
    names = attributes.pop("channelnames", None)
    if names is not None:
        spec.channelnames = names
    for name, value in attributes.items():
        spec.attribute(name.replace("__", ":"), value)
    sink = OpenImageIO.ImageOutput.create(str(path))
    assert sink is not None
    assert sink.open(str(path), spec)
    assert sink.write_image(pixels)
    assert sink.close()


@pytest.mark.parametrize("suffix", [".jpg", ".webp"])
@pytest.mark.parametrize("channels", [1, 3])
def test_lossy_formats_come_close(tmp_path: Path, suffix: str, channels: int) -> None:
    ramp = np.linspace(20, 230, 40 * 30).reshape(30, 40, 1).repeat(channels, axis=2).astype(np.uint8)
    save(Image(ramp), tmp_path / f"a{suffix}")
    assert np.abs(load(tmp_path / f"a{suffix}").pixels.astype(int) - ramp).mean() < 2


@pytest.mark.parametrize("channels", [2, 4])
def test_webp_keeps_alpha(tmp_path: Path, channels: int) -> None:
    image = picture(channels=channels)
    save(image, tmp_path / "a.webp", quality=100)
    np.testing.assert_array_equal(load(tmp_path / "a.webp").pixels[..., 3], image.pixels[..., -1])


def test_jpeg_is_laid_on_white_in_linear_light(tmp_path: Path) -> None:
    pixels = np.zeros((16, 16, 4), np.uint8)
    pixels[..., 3] = 128
    pixels[:8, :8], pixels[:8, 8:] = (90, 90, 90, 0), (90, 90, 90, 255)
    save(Image(pixels), tmp_path / "a.jpg", quality=100)
    found = load(tmp_path / "a.jpg").pixels
    np.testing.assert_allclose(found[8:], 255 * color.encode(singles([1 - 128 / 255]))[0], atol=2)
    np.testing.assert_allclose(found[:8, :8], 255, atol=2)
    np.testing.assert_allclose(found[:8, 8:], 90, atol=2)


def test_depth_follows_the_format(tmp_path: Path) -> None:
    for depth, suffix, expected in [
        (np.float32, ".png", np.uint16),
        (np.float32, ".jpg", np.uint8),
        (np.uint16, ".webp", np.uint8),
        (np.uint16, ".jpg", np.uint8),
        (np.uint8, ".exr", np.float32),
    ]:
        image = picture(depth)
        save(image, tmp_path / f"a{suffix}", quality=100)
        back = load(tmp_path / f"a{suffix}")
        assert back.pixels.dtype == expected
        light = [color.linear_light(a.pixels, linear=a.linear).mean() for a in (image, back)]
        assert light[0] == pytest.approx(light[1], abs=0.02)


@pytest.mark.parametrize("suffix", [".png", ".tif", ".exr", ".jpg", ".webp"])
@pytest.mark.parametrize(("depth", "channels"), [(np.uint8, 1), (np.uint16, 4), (np.float32, 3), (np.float32, 4)])
def test_bands_do_not_show(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str, depth: Any, channels: int
) -> None:
    """A picture is read and written in bands of rows: how many there are makes no difference."""
    rng = np.random.default_rng(4)
    picture = Image(color.quantise(rng.random((50, 9, channels), np.float32), depth), linear=depth is np.float32)
    files, read = [], []
    for rows in (1000, 7):
        monkeypatch.setattr(image_writing, "BAND_ROWS", rows)
        monkeypatch.setattr(image_reading, "BAND_ROWS", rows)
        path = tmp_path / f"{rows}{suffix}"
        save(picture, path)
        files.append(path.read_bytes())
        read.append(load(path).pixels)
    assert files[0] == files[1]
    np.testing.assert_array_equal(read[0], read[1])


@pytest.mark.parametrize("suffix", [".png", ".tif", ".exr", ".jpg", ".webp"])
def test_rows_can_be_handed_over_in_pieces(tmp_path: Path, suffix: str) -> None:
    image = Image(picture(channels=4, height=300).pixels, icc=icc_profile(), metadata=EXIF)
    whole, pieces = tmp_path / f"whole{suffix}", tmp_path / f"pieces{suffix}"
    save(image, whole)
    sample = image.with_pixels(octets([[[0, 0, 0, 0]]]))
    with writing_rows(sample, image.size_px, pieces, named=pieces) as append:
        for top, end in ((0, 64), (64, 256), (256, 300)):
            append(image.pixels[top:end])
    assert pieces.read_bytes() == whole.read_bytes()


@pytest.mark.parametrize("rows", [0, 130])
@pytest.mark.parametrize("suffix", [".png", ".tif", ".exr", ".jpg", ".webp"])
def test_writing_that_is_given_up_leaves_the_place_alone(tmp_path: Path, suffix: str, rows: int) -> None:
    image, place = picture(height=300), tmp_path / f"a{suffix}"
    place.write_bytes(b"before")

    def give_up() -> None:
        with writing_rows(image, image.size_px, place, named=place) as append:
            append(image.pixels[:rows])
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        give_up()
    assert place.read_bytes() == b"before"


@pytest.mark.parametrize(("rows", "fault"), [(299, "299 of 300 rows"), (301, "more than 300 rows")])
def test_rows_that_are_missing_or_too_many_are_a_fault(tmp_path: Path, rows: int, fault: str) -> None:
    place = tmp_path / "a.png"
    pixels = picture(height=rows).pixels
    with (
        pytest.raises(InputError, match=f"a.png: cannot be written: {fault}"),
        writing_rows(picture(), (7, 300), place, named=place) as append,
    ):
        append(pixels)
    assert not place.exists()


def test_premultiplied_files_become_straight(tmp_path: Path) -> None:
    pixels = octets([[[50, 25, 20, 100], [0, 0, 0, 0], [7, 8, 9, 255]]])
    write_with(tmp_path / "a.tif", pixels)
    expected = [[[128, 64, 51, 100], [0, 0, 0, 0], [7, 8, 9, 255]]]
    np.testing.assert_array_equal(load(tmp_path / "a.tif").pixels, expected)


def test_exr_is_premultiplied_on_disk(tmp_path: Path) -> None:
    save(Image(singles([[[0.5, 0.25, 1.0, 0.5]]]), linear=True), tmp_path / "a.exr")
    stored = np.asarray(OpenImageIO.ImageBuf(str(tmp_path / "a.exr")).get_pixels(OpenImageIO.FLOAT))
    np.testing.assert_allclose(stored, [[[0.25, 0.125, 0.5, 0.5]]], atol=1e-6)


def test_numbers_that_are_none_become_numbers(tmp_path: Path) -> None:
    pixels = singles([[[np.nan, np.inf, -np.inf], [0.5, 0.25, 2.0]]])
    write_with(tmp_path / "a.exr", pixels)
    np.testing.assert_array_equal(load(tmp_path / "a.exr").pixels, singles([[[0, 1e15, -1e15], [0.5, 0.25, 2.0]]]))


def test_dividing_by_little_alpha_stays_finite(tmp_path: Path) -> None:
    write_with(tmp_path / "a.exr", singles([[[np.inf, 1.0, 0.0, 1e-3], [np.nan, np.nan, 1.0, np.nan]]]))
    np.testing.assert_allclose(
        load(tmp_path / "a.exr").pixels, singles([[[1e15, 1e3, 0, 1e-3], [0, 0, 0, 0]]]), rtol=1e-5
    )


def test_channels_are_found_by_name(tmp_path: Path) -> None:
    pixels = singles([[[0.1, 0.2, 0.3, 0.4, 0.5]]])
    write_with(tmp_path / "a.exr", pixels, channelnames=("A", "B", "G", "R", "Z"))
    image = load(tmp_path / "a.exr")
    assert image.channels == 4
    np.testing.assert_allclose(image.pixels[..., 3], 0.1)
    np.testing.assert_allclose(image.pixels[0, 0, :3] * 0.1, [0.4, 0.3, 0.2], rtol=1e-5)


def test_one_odd_channel_is_grey(tmp_path: Path) -> None:
    write_with(tmp_path / "a.exr", singles([[[0.5]]]), channelnames=("Z",))
    assert load(tmp_path / "a.exr").pixels.tolist() == [[[0.5]]]


def test_cmyk_becomes_rgb(tmp_path: Path) -> None:
    ink = octets([[[0, 255, 255, 0], [0, 0, 0, 0], [0, 0, 0, 255]]])
    write_with(tmp_path / "a.tif", ink, tiff__ColorSpace="CMYK", channelnames=("C", "M", "Y", "K"))
    image = load(tmp_path / "a.tif")
    assert image.pixels.tolist() == [[[255, 0, 0], [255, 255, 255], [0, 0, 0]]]


def test_palettes_are_expanded(tmp_path: Path) -> None:
    write_with(tmp_path / "a.gif", octets([[[250, 10, 20], [10, 200, 30]]]))
    image = load(tmp_path / "a.gif")
    np.testing.assert_allclose(image.pixels[..., :3].astype(int), [[[250, 10, 20], [10, 200, 30]]], atol=8)


@pytest.mark.parametrize("size", [(1, 1), (1, 5000), (5000, 1)])
@pytest.mark.parametrize("suffix", [".png", ".tif", ".exr", ".jpg", ".webp"])
def test_thin_pictures_are_kept(tmp_path: Path, size: tuple[int, int], suffix: str) -> None:
    save(picture(height=size[0], width=size[1]), tmp_path / f"a{suffix}")
    assert load(tmp_path / f"a{suffix}").pixels.shape == (*size, 3)


def test_pixels_are_nobody_elses() -> None:
    pixels = np.zeros((4, 4, 3), np.uint8)
    image = Image(pixels[:, :2])
    pixels[:] = 9
    assert not image.pixels.any()
    with pytest.raises(ValueError, match="read-only"):
        image.pixels[:] = 1


@pytest.mark.parametrize("depth", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_masks_of_every_kind_are_read(tmp_path: Path, depth: Any, channels: int) -> None:
    top = 1 if depth is np.float32 else np.iinfo(depth).max
    pixels = np.zeros((2, 2, channels), depth)
    pixels[0, 1] = top
    if channels in (2, 4):
        pixels[..., -1] = top
    save(Image(pixels, linear=depth is np.float32), tmp_path / "mask.tif")
    assert load_mask(tmp_path / "mask.tif", (2, 2)).tolist() == [[0, 255], [0, 0]]
