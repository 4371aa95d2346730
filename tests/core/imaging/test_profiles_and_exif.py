"""Profiles, EXIF and dates of pictures that are written."""

from pathlib import Path

import cv2
import numpy as np
import OpenImageIO
import pytest

from core.imaging.image import usable_profile
from core.imaging.images import Attribute, Image, load, save
from core.imaging.reading import upright
from tests.core.imaging.test_images import EXIF, write_with
from tests.core.pictures import picture
from tests.core.profiles import icc_profile


@pytest.mark.parametrize("suffix", [".png", ".tif", ".jpg", ".webp"])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_profile_and_exif_are_kept(tmp_path: Path, suffix: str, channels: int) -> None:
    profile = icc_profile(b"GRAY" if channels == 1 else b"RGB ")
    image = Image(picture(channels=channels).pixels, icc=profile, metadata=EXIF)
    save(image, tmp_path / f"a{suffix}")
    back = load(tmp_path / f"a{suffix}")
    becomes_rgb = channels == 1 and suffix == ".webp"
    assert back.icc == (None if becomes_rgb else profile)
    found = {entry.name: entry.value for entry in back.metadata}
    for entry in EXIF:
        assert found[entry.name] == pytest.approx(entry.value)
    assert back.pixels.shape[2] == (3 if becomes_rgb or (suffix == ".jpg" and channels == 4) else channels)


def test_a_lossless_webp_with_exif_keeps_its_pixels(tmp_path: Path) -> None:
    image = Image(picture(channels=4).pixels, metadata=EXIF)
    save(image, tmp_path / "a.webp", quality=100)
    np.testing.assert_array_equal(load(tmp_path / "a.webp").pixels, image.pixels)


@pytest.mark.parametrize("icc", [None, icc_profile()])
def test_a_png_tags_its_colours_by_a_profile_alone(tmp_path: Path, icc: bytes | None) -> None:
    path = tmp_path / "a.png"
    save(Image(picture(channels=3).pixels, icc=icc), path)
    header = path.read_bytes().partition(b"IDAT")[0]
    assert not any(name in header for name in (b"gAMA", b"cHRM", b"sRGB"))
    assert (b"iCCP" in header) == (icc is not None)
    grey, coloured = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), cv2.imread(str(path))
    assert grey is not None
    assert coloured is not None
    assert np.abs(grey.astype(int) - cv2.cvtColor(coloured, cv2.COLOR_BGR2GRAY)).max() <= 1


@pytest.mark.parametrize("damage", [b"", b"rubbish", icc_profile()[:-4], icc_profile().replace(b"acsp", b"pcsa")])
def test_a_damaged_profile_goes(tmp_path: Path, damage: bytes) -> None:
    image = Image(picture().pixels, icc=damage)
    save(image, tmp_path / "a.png")
    assert load(tmp_path / "a.png").icc is None
    assert usable_profile(damage, 3) is None


@pytest.mark.parametrize("suffix", [".png", ".tif", ".tiff", ".exr", ".jpg", ".webp"])
def test_files_have_the_date_of_their_picture_and_no_other(tmp_path: Path, suffix: str) -> None:
    date = Attribute("DateTime", "string", "2019:03:04 05:06:07")
    for metadata in ((), (date,)):
        path = tmp_path / f"a{suffix}"
        save(Image(picture().pixels, metadata=metadata), path)
        assert [entry for entry in load(path).metadata if "Date" in entry.name] == list(metadata)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_orientation_is_applied_and_reset(tmp_path: Path, orientation: int) -> None:
    # OpenImageIO's own reading of the eight cases, by which its viewers turn pictures.
    stored = picture().pixels
    write_with(tmp_path / "a.tif", stored, Orientation=orientation)
    expected = OpenImageIO.ImageBufAlgo.reorient(OpenImageIO.ImageBuf(str(tmp_path / "a.tif"))).get_pixels(
        OpenImageIO.UINT8
    )
    image = load(tmp_path / "a.tif")
    np.testing.assert_array_equal(image.pixels, expected)
    save(image, tmp_path / "b.tif")
    np.testing.assert_array_equal(load(tmp_path / "b.tif").pixels, expected)


def test_orientation_without_a_meaning_changes_nothing() -> None:
    assert upright(picture().pixels, 9).shape == (5, 7, 3)
