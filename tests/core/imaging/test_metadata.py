"""Metadata never stops a picture's or a project's save: what cannot be carried is left out, and said."""

import os
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from core.document.document import Document
from core.document.project import load_project, save_project
from core.imaging.images import SUFFIXES, Attribute, Image, load, save
from core.imaging.metadata import as_text, sift
from core.notices import hear_notices
from tests.core.pictures import picture

TAGS = {"Artist": 0x13B, "Copyright": 0x8298, "ImageDescription": 0x10E}


def write_jpeg_with_exif(path: Path, text: bytes, *, tag: str = "Artist") -> None:
    """Write a picture of one text in EXIF, byte by byte, as a camera does that knows no UTF-8."""
    entry = struct.pack("<HHII", TAGS[tag], 2, len(text) + 1, 26)
    exif = b"Exif\0\0II*\0\x08\0\0\0" + struct.pack("<H", 1) + entry + bytes(4) + text + b"\0"
    save(picture(height=8, width=8), path)
    data = path.read_bytes()
    path.write_bytes(data[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + data[2:])


def with_metadata(*entries: tuple[str, str, Any]) -> Image:
    return Image(picture().pixels, metadata=tuple(Attribute(*entry) for entry in entries))


HOLDING = tuple(suffix for suffix in SUFFIXES if suffix != ".jxl")
"""Formats that hold metadata; OpenImageIO writes none to JPEG XL."""


def names(image: Image) -> list[str]:
    return [entry.name for entry in image.metadata]


@pytest.mark.parametrize("suffix", HOLDING)
def test_text_that_is_not_utf_8_is_carried_into_every_format(tmp_path: Path, suffix: str) -> None:
    write_jpeg_with_exif(tmp_path / "photo.jpg", "Jürgen ©".encode("latin-1"))
    opened = load(tmp_path / "photo.jpg")
    assert opened.metadata == (Attribute("Artist", "string", "Jürgen ©"),)
    save(opened, tmp_path / f"out{suffix}")
    assert Attribute("Artist", "string", "Jürgen ©") in load(tmp_path / f"out{suffix}").metadata


@pytest.mark.parametrize(
    "text", ["Jürgen ©".encode("latin-1"), "名前".encode("shift-jis"), b"\xff\xfe\x80\x00a", b"\xed\xa0\x80x"]
)
def test_a_photo_with_such_text_is_saved_as_a_project(tmp_path: Path, text: bytes) -> None:
    write_jpeg_with_exif(tmp_path / "photo.jpg", text)
    opened = Document.of(load(tmp_path / "photo.jpg"))
    save_project(opened, tmp_path / "a.weft")
    again = load_project(tmp_path / "a.weft").image
    assert again.metadata == opened.image.metadata
    save(again, tmp_path / "out.png")


def test_text_of_a_document_with_bytes_that_are_no_text_comes_back(tmp_path: Path) -> None:
    document = Document.of(picture()).with_cloth(texture_name="J\udcfcrgen.png")
    save_project(document, tmp_path / "a.weft")
    assert load_project(tmp_path / "a.weft").cloth.texture_name == "J\udcfcrgen.png"


@pytest.mark.parametrize("suffix", HOLDING)
@pytest.mark.parametrize(
    "entry",
    [
        ("Artist", "int", 2**40),
        ("Exif:FNumber", "float", None),
        ("Exif:FNumber", "float[100000]", (1.0,)),
        ("Copyright", "string", 5),
        ("Odd", "nonsense", "x"),
        ("Odd", "uint8[4]", (1, 2, 3, 400)),
        ("Odd", "string", "\ud800"),
        ("", "string", "nameless"),
        ("ICCProfile", "uint8[3]", (1, 2, 3)),
        ("compression", "string", "nonsense"),
        ("Odd", "string", object()),
    ],
)
def test_an_entry_that_cannot_be_written_costs_only_itself(tmp_path: Path, suffix: str, entry: Any) -> None:
    image = with_metadata(("Artist", "string", "A"), entry, ("Copyright", "string", "B"))
    save(image, tmp_path / f"a{suffix}")
    back = load(tmp_path / f"a{suffix}")
    assert back.size_px == image.size_px
    assert {"Artist", "Copyright"} - {entry[0]} <= set(names(back))


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    with hear_notices() as heard:
        save(with_metadata(("Exif:FNumber", "float", None), ("Artist", "string", "A")), tmp_path / "a.png")
    assert heard == [f"{tmp_path / 'a.png'}: written without metadata that it cannot hold: Exif:FNumber"]


def test_jpeg_xl_says_that_it_loses_metadata(tmp_path: Path) -> None:
    with hear_notices() as heard:
        save(with_metadata(("Artist", "string", "A")), tmp_path / "a.jxl")
    assert heard == [f"{tmp_path / 'a.jxl'}: written without metadata that it cannot hold: Artist"]
    assert load(tmp_path / "a.jxl").metadata == ()


def test_good_metadata_is_written_without_a_word(tmp_path: Path) -> None:
    write_jpeg_with_exif(tmp_path / "photo.jpg", b"A. Painter", tag="Copyright")
    with hear_notices() as heard:
        for suffix in HOLDING:
            save(load(tmp_path / "photo.jpg"), tmp_path / f"a{suffix}")
    assert heard == []


def test_a_project_leaves_out_what_json_cannot_hold(tmp_path: Path) -> None:
    with hear_notices() as heard:
        image = with_metadata(("Odd", "string", object()), ("Artist", "string", "A"))
        save_project(Document.of(image), tmp_path / "a.weft")
    assert names(load_project(tmp_path / "a.weft").image) == ["Artist"]
    assert len(heard) == 1


values = st.one_of(
    st.none(), st.integers(), st.floats(), st.text(st.characters()), st.binary(max_size=8),
    st.lists(st.integers() | st.floats(), max_size=5).map(tuple), st.just(np.arange(3)),
)  # fmt: skip
kinds = st.sampled_from(
    ["int", "float", "string", "uint8[3]", "uint16", "rational", "matrix", "timecode", "double", "x"]
)
entry_names = (
    st.sampled_from(["Artist", "Exif:FNumber", "DateTime", "IPTC:Keywords", "XMP:a", "GPS:Latitude"]) | st.text()
)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(entry_names, kinds, values), max_size=4), st.sampled_from(HOLDING))
def test_no_metadata_stops_a_save(tmp_path: Path, entries: list[tuple[str, str, Any]], suffix: str) -> None:
    image = with_metadata(*entries)
    with hear_notices():
        save(image, tmp_path / f"a{suffix}")
        save_project(Document.of(image), tmp_path / "a.weft")
    assert load(tmp_path / f"a{suffix}").size_px == image.size_px
    assert load_project(tmp_path / "a.weft").image.size_px == image.size_px


def test_bad_entries_are_found_in_few_trials() -> None:
    trials = []

    def fits(entries: tuple[Attribute, ...]) -> bool:
        trials.append(entries)
        return all(entry.value != 700 for entry in entries)

    metadata = tuple(Attribute(str(number), "int", number) for number in range(1024))
    kept, dropped = sift(metadata, fits)
    assert [entry.value for entry in dropped] == [700]
    assert kept == metadata[:700] + metadata[701:]
    assert len(trials) <= 21


def test_text_is_left_alone_where_it_is_text() -> None:
    assert as_text("名前 ü") == "名前 ü"
    assert as_text(5) == 5
    assert as_text("\ud800") == "?"


@pytest.mark.parametrize("suffix", HOLDING)
def test_a_file_whose_name_is_not_utf_8_is_written_and_read(tmp_path: Path, suffix: str) -> None:
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/J\xfcrgen" + suffix.encode()))
    image = with_metadata(("Artist", "string", "A"))
    save(image, path)
    back = load(path)
    assert back.size_px == image.size_px
    assert "Artist" in names(back)
