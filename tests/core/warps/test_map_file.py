"""An ST map or a displacement opened as a warp does what OpenImageIO does with it."""

from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from app.cli import main
from core.arrays import Floats, InputError, Singles
from core.document.document import Document
from core.document.project import load_project, save_project
from core.imaging.images import Image, load, save
from core.warps.map_file import WarpMap, read_warp_map

pytestmark = pytest.mark.gpu

WIDTH, HEIGHT = 240, 160


def lens(size: tuple[int, int] = (WIDTH, HEIGHT), bend: float = 0.12, zoom: float = 0.85) -> Floats:
    """Return where each pixel of a result of `size` comes from under a lens, in shares from the top left corner."""
    y, x = np.mgrid[0 : size[1], 0 : size[0]]
    at = np.stack([(x + 0.5) / size[0], (y + 0.5) / size[1]], axis=-1) * 2 - 1
    found: Floats = (at * zoom * (1 + bend * (at**2).sum(axis=-1, keepdims=True)) + 1) / 2
    return found


def write_st_map(path: Path, places: Floats, covered: float = 1.0) -> None:
    channels = [places[..., 0], 1 - places[..., 1], 0 * places[..., 0], np.full(places.shape[:2], covered)]
    save(Image(np.stack(channels, axis=-1).astype(np.float32), linear=True), path)


def ramp() -> Image:
    """Return a picture whose colours say where a pixel is, as shares."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    return Image(np.stack([(x + 0.5) / WIDTH, (y + 0.5) / HEIGHT, 0 * x], axis=-1).astype(np.float32), linear=True)


def by_openimageio(picture: Path, st_map: Path) -> Singles:
    source, places = OpenImageIO.ImageBuf(str(picture)), OpenImageIO.ImageBuf(str(st_map))
    roi = OpenImageIO.ROI(0, places.spec().width, 0, places.spec().height, 0, 1, 0, 3)
    warped = OpenImageIO.ImageBufAlgo.st_warp(source, places, "triangle", 2.0, 0, 1, False, True, roi)
    assert not warped.has_error
    return np.asarray(warped.get_pixels(OpenImageIO.FLOAT), np.float32)


def apart_px(ours: Path, theirs: Singles) -> float:
    """Return how far apart at most the places are that two results show, well inside them."""
    inside = np.s_[12:-12, 12:-12, :2]
    return float(np.hypot(*((load(ours).pixels[inside] - theirs[inside]) * [WIDTH, HEIGHT]).transpose(2, 0, 1)).max())


@pytest.mark.parametrize("size", [(WIDTH, HEIGHT), (300, 220)])
def test_an_st_map_that_is_opened_does_what_openimageio_does_with_it(tmp_path: Path, size: tuple[int, int]) -> None:
    write_st_map(tmp_path / "st.exr", lens(size))
    save(ramp(), tmp_path / "ramp.exr")
    words = [
        "warp",
        str(tmp_path / "ramp.exr"),
        "--from-stmap",
        str(tmp_path / "st.exr"),
        "-o",
        str(tmp_path / "o.exr"),
    ]
    assert main(words) == 0
    assert load(tmp_path / "o.exr").size_px == size
    assert apart_px(tmp_path / "o.exr", by_openimageio(tmp_path / "ramp.exr", tmp_path / "st.exr")) < 0.05


def test_openimageio_does_with_our_st_map_what_we_do(tmp_path: Path) -> None:
    save(ramp(), tmp_path / "ramp.exr")
    words = ["--preset", "bulge", "--bend=25", "--frame", "picture", "--stmap", str(tmp_path / "st.exr")]
    assert main(["warp", str(tmp_path / "ramp.exr"), *words, "-o", str(tmp_path / "o.exr")]) == 0
    assert apart_px(tmp_path / "o.exr", by_openimageio(tmp_path / "ramp.exr", tmp_path / "st.exr")) < 0.05
    again = ["--from-stmap", str(tmp_path / "st.exr"), "-o", str(tmp_path / "again.exr")]
    assert main(["warp", str(tmp_path / "ramp.exr"), *again]) == 0
    assert apart_px(tmp_path / "again.exr", load(tmp_path / "o.exr").pixels) < 0.05


def test_a_displacement_is_the_same_in_pixels(tmp_path: Path) -> None:
    places = lens()
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    offsets = places * [WIDTH, HEIGHT] - np.stack([x + 0.5, y + 0.5], axis=-1)
    channels = [offsets[..., 0], -offsets[..., 1], 0 * offsets[..., 0]]
    save(Image(np.stack(channels, axis=-1).astype(np.float32), linear=True), tmp_path / "d.exr")
    np.testing.assert_allclose(read_warp_map(tmp_path / "d.exr", "displacement").places, places, atol=1e-6)


def test_the_warp_meets_the_map_and_goes_on_beyond_it() -> None:
    found = WarpMap(lens(zoom=0.7).astype(np.float32))
    points = np.array([[WIDTH / 2 - 0.5, HEIGHT / 2 - 0.5], [60.3, 50.7], [2.0, 3.0]])
    at = found.warp((WIDTH, HEIGHT))(points)
    np.testing.assert_allclose(at[0], points[0], atol=1e-3)
    unit = (at + 0.5) / [WIDTH, HEIGHT] * 2 - 1
    back = (unit * 0.7 * (1 + 0.12 * (unit**2).sum(axis=-1, keepdims=True)) + 1) / 2 * [WIDTH, HEIGHT] - 0.5
    np.testing.assert_allclose(back[:2], points[:2], atol=0.01)
    assert (at[2] < -5).all()  # beyond the result's corner
    assert np.isfinite(at).all()


def test_what_is_not_covered_is_not_used() -> None:
    places = lens()
    places[:, 150:] = np.nan
    at = WarpMap(places.astype(np.float32)).warp((WIDTH, HEIGHT))(np.array([[100.0, 80.0], [230.0, 80.0]]))
    assert at[0, 0] < 149 < at[1, 0]


def test_features_keep_their_shape_under_a_map_and_a_project_holds_it(tmp_path: Path) -> None:
    write_st_map(tmp_path / "st.exr", lens())
    save(ramp(), tmp_path / "ramp.exr")
    found = read_warp_map(tmp_path / "st.exr")
    save_project(Document.of(ramp()).changed(warp_map=found), tmp_path / "a.weft")
    held = load_project(tmp_path / "a.weft").warp_map
    assert held is not None
    np.testing.assert_array_equal(held.places, found.places)
    words = ["render", str(tmp_path / "a.weft"), "--frame", "picture", "-o", str(tmp_path / "o.exr")]
    assert main(words) == 0
    assert apart_px(tmp_path / "o.exr", by_openimageio(tmp_path / "ramp.exr", tmp_path / "st.exr")) < 0.05


@pytest.mark.parametrize(
    ("name", "fault"),
    [("grey.exr", "a warp map is a float picture with red and green"), ("png.png", "a warp map is a float picture")],
)
def test_what_is_no_map_is_named(tmp_path: Path, name: str, fault: str) -> None:
    pixels = np.zeros((4, 4, 1), np.float32) if name == "grey.exr" else np.zeros((4, 4, 3), np.uint8)
    save(Image(pixels, linear=name == "grey.exr"), tmp_path / name)
    with pytest.raises(InputError, match=f"{name}: {fault}"):
        read_warp_map(tmp_path / name)
    write_st_map(tmp_path / "empty.exr", lens(), covered=0.0)
    with pytest.raises(InputError, match=r"empty.exr: a warp map that covers nothing"):
        read_warp_map(tmp_path / "empty.exr")
