"""Of an archive only what is asked for is unpacked, and within bounds."""

import tracemalloc
import zipfile
from pathlib import Path

import pytest

from core.arrays import InputError
from core.document.document import Document
from core.document.project import load_project, save_project
from core.files import members
from core.files.members import Members
from tests.core.pictures import picture


@pytest.fixture
def project(tmp_path: Path) -> Path:
    path = tmp_path / "a.weft"
    save_project(Document.of(picture()), path)
    return path


def test_a_member_that_nobody_needs_costs_nothing(project: Path) -> None:
    with zipfile.ZipFile(project, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("ballast.bin", bytes(100_000_000))
    tracemalloc.start()
    assert load_project(project).size_px == (7, 5)
    assert tracemalloc.get_traced_memory()[1] < 20e6
    tracemalloc.stop()


def test_a_member_that_grows_out_of_all_proportion_is_refused(project: Path) -> None:
    with zipfile.ZipFile(project) as archive:
        text = archive.read("weft.json")
    with zipfile.ZipFile(project, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("weft.json", text)
        archive.writestr("image.png", bytes(100_000_000))
    tracemalloc.start()
    with pytest.raises(InputError, match=r"image: image\.png would grow out of all proportion"):
        load_project(project)
    assert tracemalloc.get_traced_memory()[1] < 20e6
    tracemalloc.stop()


def test_all_members_together_are_bounded(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(members, "TOTAL_BYTES", 100)
    with zipfile.ZipFile(project) as archive, pytest.raises(InputError, match="more than a document can"):
        Members(archive).read("weft.json")
