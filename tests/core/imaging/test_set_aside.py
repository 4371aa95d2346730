"""Very large pictures wait in a file without a name: the same pixels, and no memory but for what is looked at."""

import os
import tempfile
from pathlib import Path

import numpy as np
import pytest

from app.render.export import render_mesh
from core.arrays import InputError, Pixels
from core.grid import Grid
from core.imaging import set_aside
from core.imaging.images import Image, load, save
from core.imaging.set_aside import let_go


def noise(shape: tuple[int, ...], depth: type = np.uint8) -> Pixels:
    return np.random.default_rng(0).integers(0, np.iinfo(depth).max, shape, depth)


@pytest.fixture(autouse=True)
def small_pictures_are_large(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(set_aside, "LARGE_BYTES", 1)


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [1, 3])
def test_pixels_that_are_set_aside_are_those_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, depth: type, channels: int
) -> None:
    pixels = noise((600, 70, channels), depth)
    save(Image(pixels.copy()), tmp_path / "a.png")
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    image = load(tmp_path / "a.png")
    assert not image.pixels.flags.writeable
    assert not image.pixels.flags.owndata
    np.testing.assert_array_equal(image.pixels, pixels)
    let_go(image.pixels)
    np.testing.assert_array_equal(image.pixels[500:, :50], pixels[500:, :50])
    assert not list(scratch.iterdir())


def test_what_was_looked_at_is_let_go(tmp_path: Path) -> None:
    save(Image(noise((3000, 4000, 3))), tmp_path / "a.tif")
    image = load(tmp_path / "a.tif")

    def resident() -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    if not Path("/proc/self/statm").exists():
        pytest.skip("the system does not say what is in memory")
    total = int(image.pixels.sum())
    held = resident()
    let_go(image.pixels[10:])
    assert held - resident() > 0.9 * image.pixels.nbytes
    assert int(image.pixels.sum()) == total


def test_a_picture_that_is_set_aside_is_drawn_as_one_in_memory(tmp_path: Path) -> None:
    pixels = noise((300, 400, 3))
    save(Image(pixels.copy()), tmp_path / "a.png")
    nodes = Grid(400, 300).nodes
    drawn = [
        render_mesh(each, nodes, 0.7 * nodes, size=(280, 210)) for each in (load(tmp_path / "a.png"), Image(pixels))
    ]
    np.testing.assert_array_equal(drawn[0].pixels, drawn[1].pixels)


@pytest.mark.parametrize("kind", ["full", "missing"])
def test_without_room_on_the_disk_pixels_are_in_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    pixels = noise((60, 70, 3))
    save(Image(pixels.copy()), tmp_path / "a.png")
    if kind == "full":
        monkeypatch.setattr(os, "posix_fallocate", fail)
    else:
        monkeypatch.setattr(tempfile, "TemporaryFile", fail)
    image = load(tmp_path / "a.png")
    np.testing.assert_array_equal(image.pixels, pixels)
    assert image.pixels.base is None


def test_a_file_that_is_cut_short_is_refused_and_leaves_nothing_open(tmp_path: Path) -> None:
    save(Image(noise((2000, 70, 3))), tmp_path / "a.tif")
    data = (tmp_path / "a.tif").read_bytes()
    (tmp_path / "b.tif").write_bytes(data[: len(data) // 2])
    opened = len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").exists() else 0  # noqa: PTH208
    with pytest.raises(InputError, match="damaged or cut short"):
        load(tmp_path / "b.tif")
    if opened:
        assert len(os.listdir("/proc/self/fd")) == opened  # noqa: PTH208


def test_pixels_that_are_changed_once_read_are_in_memory(tmp_path: Path) -> None:
    save(Image(noise((60, 70, 4))), tmp_path / "a.png")
    assert load(tmp_path / "a.png").pixels.base is None
