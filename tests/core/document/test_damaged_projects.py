"""Projects that are damaged, newer, or of another program are refused in one line."""

import contextlib
import errno
import json
import os
import zipfile
from pathlib import Path

import numpy as np
import pytest

from core.arrays import InputError
from core.document.document import Document, Pin
from core.document.project import load_project, save_project
from core.imaging.images import Image
from core.rasters.raster import Raster
from tests.core.document.test_project import rewritten


@pytest.fixture
def project(tmp_path: Path) -> Path:
    document = Document.of(Image(np.full((6, 8, 3), 9, np.uint8))).changed(pins=(Pin((0.5, 0.5), (0.6, 0.5)),))
    save_project(document, tmp_path / "project.weft")
    return tmp_path / "project.weft"


def test_a_newer_version_is_refused(project: Path) -> None:
    rewritten(project, version=99)
    with pytest.raises(InputError, match=r"project\.weft: made by a newer Weft \(format 99"):
        load_project(project)


@pytest.mark.parametrize("cut", [0, 1, 100, -30])
def test_a_cut_file_is_refused(project: Path, cut: int) -> None:
    project.write_bytes(project.read_bytes()[:cut])
    with pytest.raises(InputError, match=r"project\.weft: not a Weft project, or damaged"):
        load_project(project)


def test_flipped_bytes_are_refused_or_harmless(project: Path) -> None:
    good = project.read_bytes()
    for at in range(0, len(good), 7):
        project.write_bytes(good[:at] + bytes([good[at] ^ 0xFF]) + good[at + 1 :])
        with contextlib.suppress(InputError):
            load_project(project)


@pytest.mark.parametrize("change", ["encrypted", "lzma", "deep"])
def test_what_cannot_be_unpacked_is_refused(project: Path, change: str) -> None:
    text = "[" * 100_000 if change == "deep" else json.dumps(list(range(500)))
    with zipfile.ZipFile(project, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("weft.json", text)
    content = bytearray(project.read_bytes())
    if change == "encrypted":
        for header, flags in ((b"PK\1\2", 8), (b"PK\3\4", 6)):
            content[content.find(header) + flags] |= 1
    if change == "lzma":
        content[55] ^= 0xFF
    project.write_bytes(content)
    with pytest.raises(InputError, match=r"project\.weft: not a Weft project, or damaged"):
        load_project(project)


def test_no_room_to_unpack_is_named(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    document = load_project(project)
    monkeypatch.setattr(Path, "write_bytes", full)
    monkeypatch.setattr("core.document.project._encode", full)
    with pytest.raises(InputError, match=r"project\.weft: cannot be unpacked: no space left on device"):
        load_project(project)
    with pytest.raises(InputError, match=r"again\.weft: no space left on device"):
        save_project(document, project.with_name("again.weft"))
    assert [file.name for file in project.parent.iterdir()] == ["project.weft"]


@pytest.mark.parametrize(
    ("document", "fault"),
    [
        (None, "it has no document"),
        ({}, "image: is missing"),
        ({"image": {"file": "no.png"}}, "image: its file is missing"),
        ({"image": {"file": "weft.json"}}, "image: holds a damaged picture"),
    ],
)
def test_damage_inside_is_named(project: Path, document: object, fault: str) -> None:
    rewritten(project, document=document)
    with pytest.raises(InputError, match=fault):
        load_project(project)


@pytest.mark.parametrize(
    ("part", "value", "fault"),
    [
        ("warp", {"keep": "wobbly"}, "warp.keep: is not one of"),
        ("warp", {"bend": "much"}, "warp.bend: is not a finite number"),
        ("warp", {"bend": 10**400}, "warp.bend: is not a finite number"),
        ("outline", {"ring": [[0, 10**400]] * 12}, "outline: holds NaN or infinity"),
        ("pins", [{"at": [0.5], "to": [0.1, 0.2]}], "pins.0.at: is not a list of 2"),
        ("pins", {"at": 1}, "pins: is not a list"),
        ("pins", [{"at": [0, 0], "to": [0, 0], "ring": {"scale": -1}}], "ring: a scale of -1 is not from"),
        ("outline", {"ring": [[0, 0]] * 5}, "outline: needs 12 points"),
        ("curves", [{"source": "x", "target": []}], "curves.0.source"),
        ("features", [{"number": 1, "keep": "wobbly"}], "features.0.keep: is not one of"),
        ("features", [{"number": 1, "weight": 1.5}], "protection of a feature by 1.5"),
        ("features", [{"number": 1, "least": 2, "most": 1}], "size of a feature from 2 to 1"),
        ("mask", {"file": "image.png"}, "mask: is not an 8-bit grey picture"),
    ],
)
def test_a_value_that_does_not_fit_is_named(project: Path, part: str, value: object, fault: str) -> None:
    with zipfile.ZipFile(project) as archive:
        document = json.loads(archive.read("weft.json"))["document"]
    rewritten(project, document=document | {part: value})
    with pytest.raises(InputError, match=fault):
        load_project(project)


@pytest.mark.parametrize("name", ["mask", "matte", "source_mask"])
def test_a_mask_of_another_size_is_refused(project: Path, name: str) -> None:
    document = load_project(project).changed(**{name: Raster.filled(3, 3)})
    save_project(document, project)
    with pytest.raises(InputError, match=f"the {name} has another size"):
        load_project(project)


def test_a_project_that_asks_for_a_later_zip_is_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "a.weft"
    save_project(Document.of(Image(np.full((6, 8, 3), 9, np.uint8))), path)
    data = bytearray(path.read_bytes())
    data[data.index(b"PK\x01\x02") + 6] = 99  # the version that is needed to unpack the first member
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"a\.weft"):
        load_project(path)
