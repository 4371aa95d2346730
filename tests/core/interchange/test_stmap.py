"""An ST map does in a compositing program what the warp did here."""

from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from core.arrays import Singles
from core.canvas import Canvas
from core.imaging.images import load
from core.interchange.stmap import st_map_rows, write_st_map
from core.warps.presets import make_warp

WIDTH, HEIGHT = 60, 40


def nodes(cells: int = 20) -> np.ndarray:
    x, y = (np.linspace(-0.5, size - 0.5, cells + 1) for size in (WIDTH, HEIGHT))
    return np.stack(np.meshgrid(x, y), axis=-1)


def whole_map(rest: np.ndarray, warped: np.ndarray, source_px: tuple[int, int], canvas: Canvas) -> Singles:
    return np.concatenate(list(st_map_rows(rest, warped, source_px, canvas)))


def test_identity_is_the_pixel_centres() -> None:
    found = whole_map(nodes(), nodes(), (WIDTH, HEIGHT), Canvas(WIDTH, HEIGHT))
    np.testing.assert_allclose(found[7, :, 0], (np.arange(WIDTH) + 0.5) / WIDTH, atol=1e-6)
    np.testing.assert_allclose(found[:, 9, 1], 1 - (np.arange(HEIGHT) + 0.5) / HEIGHT, atol=1e-6)
    assert (found[..., 3] == 1).all()


def test_where_the_picture_does_not_come_nothing_is_covered() -> None:
    found = whole_map(nodes(), nodes() + [10, 0], (WIDTH, HEIGHT), Canvas(WIDTH + 20, HEIGHT))
    assert (found[:, :10] == 0).all()
    assert (found[:, 10:70, 3] == 1).all()
    assert (found[:, 70:] == 0).all()


def test_no_seam_stays_open_on_pixel_centres() -> None:
    found = whole_map(nodes(), nodes() + 0.5, (WIDTH, HEIGHT), Canvas(WIDTH + 1, HEIGHT + 1))
    assert (found[..., 3] == 1).all()


def test_of_a_fold_the_upright_side_is_seen() -> None:
    folded = nodes()
    folded[..., 0] = np.minimum(folded[..., 0], 59 - folded[..., 0])
    found = whole_map(nodes(), folded, (WIDTH, HEIGHT), Canvas(WIDTH, HEIGHT))
    np.testing.assert_allclose(found[9, :29, 0], (np.arange(29) + 0.5) / WIDTH, atol=1e-6)


def test_no_more_than_a_band_is_held(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.interchange.stmap._BAND_ROWS", 7)
    bands = st_map_rows(nodes(), nodes(), (WIDTH, HEIGHT), Canvas(WIDTH, HEIGHT))
    assert [len(band) for band in bands] == [7, 7, 7, 7, 7, 5]


def test_many_bands_and_chunks_are_one_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    warped = make_warp("twist", WIDTH, HEIGHT, bend=80)(nodes())
    whole = whole_map(nodes(), warped, (WIDTH, HEIGHT), Canvas(WIDTH, HEIGHT))
    monkeypatch.setattr("core.interchange.stmap._BAND_ROWS", 7)
    monkeypatch.setattr("core.interchange.stmap._CHUNK", 50)
    pieces = whole_map(nodes(), warped, (WIDTH, HEIGHT), Canvas(WIDTH, HEIGHT))
    np.testing.assert_allclose(pieces, whole, atol=1e-6)


def test_the_file_holds_the_rows_of_every_band(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.interchange.stmap._BAND_ROWS", 16)
    grid = nodes(), nodes() + 2.5, (WIDTH, HEIGHT), Canvas(WIDTH + 5, HEIGHT + 5)
    write_st_map(*grid, tmp_path / "a.exr", named=tmp_path / "a.exr")
    image = load(tmp_path / "a.exr")
    assert image.linear
    np.testing.assert_array_equal(image.pixels, whole_map(*grid))


def test_openimageio_warps_alike(tmp_path: Path) -> None:
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    source = np.stack([x, y, 0 * x], axis=-1).astype(np.float32)
    warp = make_warp("arc", WIDTH, HEIGHT, bend=30)
    canvas = Canvas.around(warp(nodes()))
    path = tmp_path / "st.exr"
    write_st_map(nodes(), canvas.placed(warp(nodes())), (WIDTH, HEIGHT), canvas, path, named=path)
    st = OpenImageIO.ImageBuf(str(tmp_path / "st.exr"))
    done = OpenImageIO.ImageBufAlgo.st_warp(OpenImageIO.ImageBuf(source), st, "triangle", 0, 0, 1, False, True, st.roi)
    assert not done.has_error
    found = np.asarray(done.get_pixels(OpenImageIO.FLOAT))
    # The source's colours are its coordinates: each pixel of the result names the place it was taken from.
    rest = np.array([[30.0, 20.0], [12.0, 9.0], [47.0, 30.0]])
    for place, at in zip(rest, np.rint(canvas.placed(warp(rest))).astype(int), strict=True):
        np.testing.assert_allclose(found[at[1], at[0], :2], place, atol=1.2)
