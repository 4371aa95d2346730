"""A picture that is too large is refused in one line, before memory is taken for it."""

import struct
import tracemalloc
import zipfile
import zlib
from pathlib import Path

import pytest

from core.arrays import InputError
from core.canvas import MOST_PIXELS
from core.document.document import Document
from core.document.project import load_project, save_project
from core.imaging import picture_bounds
from core.imaging.images import load, save
from tests.core.pictures import picture


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width: int, height: int) -> bytes:
    """Return a grey PNG of a size, with few of its rows."""
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b"")


def tif(width: int, height: int) -> bytes:
    """Return a grey TIFF of a size, in one strip that is too short."""
    strip = zlib.compress(bytes(1_000_000))
    entries = [(256, width), (257, height), (258, 8), (259, 8), (262, 1), (273, 200), (277, 1), (278, height)]
    entries.append((279, len(strip)))
    table = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in entries)
    return (b"II*\0" + struct.pack("<IH", 8, len(entries)) + table + bytes(4)).ljust(200, b"\0") + strip


@pytest.mark.parametrize(("name", "content"), [("a.png", png(70_000, 100)), ("a.tif", tif(100, 70_000))])
def test_a_picture_with_too_long_a_side_is_refused(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    tracemalloc.start()
    with pytest.raises(
        InputError, match=rf"{name}: \d+x\d+ pixels: a picture may have 65536 a side, 1073741824 in all$"
    ):
        load(tmp_path / name)
    assert tracemalloc.get_traced_memory()[1] < 5e6
    tracemalloc.stop()


def test_a_picture_with_too_many_pixels_is_refused() -> None:
    picture_bounds.check_size((32_768, 32_768), 0, "a.png")
    assert MOST_PIXELS == 32_768 * 32_768
    with pytest.raises(InputError, match=r"a\.png: 32768x32769 pixels: a picture may have"):
        picture_bounds.check_size((32_768, 32_769), 0, "a.png")


@pytest.mark.parametrize(("name", "header"), [("a.bmp", b""), ("a.pgm", b"P5 70000 100 255\n")])
def test_what_the_reader_of_a_format_finds_too_large_is_said_so(tmp_path: Path, name: str, header: bytes) -> None:
    sizes = struct.pack("<IHHIIiiHHIIiiII", 1000, 0, 0, 54, 40, 70_000, 100, 1, 24, 0, 0, 0, 0, 0, 0)
    (tmp_path / name).write_bytes((header or b"BM" + sizes) + bytes(100))
    with pytest.raises(InputError, match=rf"{name}: has more pixels than a picture may have, or the machine can hold$"):
        load(tmp_path / name)


def test_a_picture_that_the_machine_cannot_hold_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    save(picture(height=50, width=100, channels=3), tmp_path / "a.png")
    monkeypatch.setattr(picture_bounds, "memory_bytes", lambda: 29_999)
    with pytest.raises(InputError, match=r"a\.png: 100x50 pixels take 0\.0 GB, the machine has 0\.0 GB$"):
        load(tmp_path / "a.png")
    monkeypatch.setattr(picture_bounds, "memory_bytes", lambda: 30_000)
    assert load(tmp_path / "a.png").size_px == (100, 50)
    monkeypatch.setattr(picture_bounds, "memory_bytes", lambda: None)
    assert load(tmp_path / "a.png").size_px == (100, 50)


def test_the_memory_of_the_machine_is_known_and_a_limit_below_it_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert (picture_bounds.memory_bytes() or 0) > 2**27
    monkeypatch.setattr(picture_bounds, "_GROUP_LIMIT", tmp_path / "memory.max")
    (tmp_path / "memory.max").write_text("max\n")
    assert (picture_bounds.memory_bytes() or 0) > 2**27
    (tmp_path / "memory.max").write_text("1000000\n")
    assert picture_bounds.memory_bytes() == 1_000_000


def test_the_members_of_a_project_are_bounded_too(tmp_path: Path) -> None:
    path = tmp_path / "a.weft"
    save_project(Document.of(picture()), path)
    with zipfile.ZipFile(path) as archive:
        text = archive.read("weft.json")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("weft.json", text)
        archive.writestr("image.png", png(70_000, 100))
    with pytest.raises(InputError, match=r"a\.weft: damaged project: image: 70000x100 pixels: a picture may have"):
        load_project(path)
