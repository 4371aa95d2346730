"""Full disks, read-only and vanished folders, and no memory, while the program writes: nothing is lost."""

import errno
import os
import resource
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import NoReturn

import pytest

from app.files import document_io
from app.model.requests import ExportOptions
from app.render.picture_file import exporting
from app.state.recovery import Recovery
from core.document import project as project_module
from core.document.project import load_project
from core.imaging.images import load
from tests.app.driver import EditorDriver

pytestmark = pytest.mark.gpu

Fault = Callable[[Path, pytest.MonkeyPatch], AbstractContextManager[None]]


@contextmanager
def full_disk(folder: Path, patch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let no file of the process grow beyond a few hundred bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (300, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextmanager
def read_only(folder: Path, patch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let nothing be made, as on a disk that is mounted for reading only."""

    def refuse(*_: object, **__: object) -> NoReturn:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    with patch.context() as inner:
        inner.setattr(tempfile, "mkstemp", refuse)
        inner.setattr(tempfile, "mkdtemp", refuse)
        yield


@contextmanager
def no_memory(folder: Path, patch: pytest.MonkeyPatch) -> Iterator[None]:
    """Fail to allocate while pixels are packed."""

    def refuse(*_: object, **__: object) -> NoReturn:
        raise MemoryError

    with patch.context() as inner:
        inner.setattr(project_module, "_cache", refuse)
        inner.setattr("core.imaging.writing._fit_to_format", refuse)
        yield


@contextmanager
def vanished(folder: Path, patch: pytest.MonkeyPatch) -> Iterator[None]:
    """Take the folder away, and bring it back."""
    shutil.move(folder, f"{folder}-away")
    yield
    shutil.rmtree(folder, ignore_errors=True)
    shutil.move(f"{folder}-away", folder)


FAULTS: dict[str, Fault] = {"full": full_disk, "read-only": read_only, "no memory": no_memory, "vanished": vanished}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    place = tmp_path / "work"
    place.mkdir()
    return place


def opened(folder: Path) -> EditorDriver:
    """Return an editor on a project that is saved and exported, and then bent."""
    drive = EditorDriver()
    drive.editor.exporter = exporting
    drive.editor.project_path = folder / "a.weft"
    drive.editor.edit("Bend", drive.document.with_warp(preset="arc", bend=10.0))
    document_io.save(drive.editor)
    document_io.export(drive.editor, ExportOptions(folder / "a.png", (200, 150)))
    drive.frame()
    drive.editor.edit("Bend", drive.document.with_warp(bend=44.0))
    drive.editor.notices.clear()
    return drive


@pytest.mark.parametrize("fault", FAULTS)
def test_a_save_that_fails_is_said_and_loses_nothing(folder: Path, fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = opened(folder)
    before, document = (folder / "a.weft").read_bytes(), drive.document
    with FAULTS[fault](folder, monkeypatch):
        document_io.save(drive.editor)
        drive.frame()
    assert [notice.level for notice in drive.editor.notices] == ["error"]
    assert (folder / "a.weft").read_bytes() == before
    assert drive.document is document
    assert not drive.editor.history.is_saved
    document_io.save(drive.editor)
    drive.frame()
    assert load_project(folder / "a.weft").warp.bend == 44.0
    assert sorted(file.name for file in folder.iterdir()) == ["a.png", "a.weft", "a.weft~"]


@pytest.mark.parametrize("fault", FAULTS)
def test_an_export_that_fails_is_said_and_leaves_the_older_one(
    folder: Path, fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive = opened(folder)
    before = (folder / "a.png").read_bytes()
    with FAULTS[fault](folder, monkeypatch):
        document_io.export(drive.editor, ExportOptions(folder / "a.png", (200, 150)))
        drive.frame()
    assert [notice.level for notice in drive.editor.notices] == ["error"]
    assert (fault == "no memory") == (drive.editor.notices[0].text == "Not enough memory")
    assert (folder / "a.png").read_bytes() == before
    document_io.export(drive.editor, ExportOptions(folder / "a.png", (100, 75), frame="picture"))
    drive.frame()
    assert load(folder / "a.png").size_px == (100, 75)
    assert sorted(file.name for file in folder.iterdir()) == ["a.png", "a.weft"]


@pytest.mark.parametrize("fault", FAULTS)
def test_an_autosave_that_fails_is_shown_until_it_succeeds(
    folder: Path, fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive = opened(folder)
    recovery = drive.editor.recovery = Recovery(drive.editor.jobs, folder=folder / "kept", every_s=1.0)

    def after_a_while() -> None:
        drive.frame()
        drive.clock.now += 5.0
        drive.frame().frame()

    after_a_while()
    drive.editor.edit("Bend", drive.document.with_warp(bend=50.0))
    with FAULTS[fault](folder, monkeypatch):
        after_a_while()
        shown = recovery.fault
    if fault == "vanished":  # it is made anew
        assert shown is None
        return
    assert shown is not None
    assert {load_project(rescue).warp.bend for rescue in (folder / "kept").glob("*.weft")} == {44.0}
    after_a_while()
    assert recovery.fault is None
    bends = {load_project(rescue).warp.bend for rescue in (folder / "kept").glob("*.weft")}
    assert 50.0 in bends
