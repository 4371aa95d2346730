"""A project that somebody else writes, and the version before."""

from pathlib import Path

import pytest

from app.files import document_io
from app.model.requests import AskChanged, SaveFile
from app.state.project_file import keep_backup
from core.document.document import Document
from core.document.project import load_project, save_project
from tests.app.driver import EditorDriver, document


def bent(by: float) -> Document:
    return document().with_warp(preset="arc", bend=by)


class Window:
    """An editor on a project, in one of several windows."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.drive = EditorDriver()
        document_io.open_path(self.drive.editor, path)
        self.drive.frame()

    def bend(self, by: float) -> "Window":
        self.drive.editor.edit("Bend", self.drive.document.with_warp(preset="arc", bend=by))
        return self

    def save(self) -> "Window":
        document_io.save(self.drive.editor)
        self.drive.frame()
        return self

    def asked(self) -> AskChanged:
        request = self.drive.editor.requests.pop()
        assert isinstance(request, AskChanged)
        return request


@pytest.fixture
def path(tmp_path: Path) -> Path:
    save_project(bent(1), tmp_path / "work.weft")
    return tmp_path / "work.weft"


def bend_of(path: Path) -> float:
    return load_project(path).warp.bend


def test_of_two_windows_the_second_save_is_asked_about(path: Path) -> None:
    one, other = Window(path), Window(path)
    one.bend(10).save()
    assert bend_of(path) == 10
    other.bend(20).save()
    assert other.asked().name == "work.weft"
    assert bend_of(path) == 10
    assert not other.drive.editor.history.is_saved
    assert other.drive.document.warp.bend == 20


def test_the_other_version_is_written_over_when_that_is_wanted(path: Path) -> None:
    one, other = Window(path), Window(path)
    one.bend(10).save()
    other.bend(20).save().asked().then("overwrite")
    other.drive.frame()
    assert bend_of(path) == 20
    assert bend_of(path.with_name("work.weft~")) == 10
    assert other.drive.editor.history.is_saved
    other.bend(30).save()
    assert other.drive.editor.requests == []
    assert bend_of(path) == 30


def test_the_other_version_is_taken_in_when_that_is_wanted(path: Path) -> None:
    one, other = Window(path), Window(path)
    one.bend(10).save()
    other.bend(20).save().asked().then("reload")
    other.drive.frame()
    assert other.drive.document.warp.bend == 10
    other.bend(30).save()
    assert bend_of(path) == 30


def test_work_is_saved_elsewhere_when_that_is_wanted(path: Path, tmp_path: Path) -> None:
    one, other = Window(path), Window(path)
    one.bend(10).save()
    other.bend(20).save().asked().then("save_as")
    request = other.drive.editor.requests.pop()
    assert isinstance(request, SaveFile)
    request.then(tmp_path / "mine.weft")
    other.drive.frame()
    assert bend_of(path) == 10
    assert bend_of(tmp_path / "mine.weft") == 20


def test_saves_in_quick_succession_are_not_asked_about(path: Path) -> None:
    window = Window(path).bend(10)
    document_io.save(window.drive.editor)
    document_io.save(window.drive.editor)
    window.drive.frame()
    window.bend(20).save()
    assert window.drive.editor.requests == []
    assert bend_of(path) == 20


def test_a_file_that_is_gone_is_written_anew(path: Path) -> None:
    window = Window(path).bend(10)
    path.unlink()
    window.save()
    assert bend_of(path) == 10


def test_the_version_before_is_kept_unless_that_is_switched_off(path: Path) -> None:
    window = Window(path).bend(10).save()
    assert bend_of(path.with_name("work.weft~")) == 1
    window.bend(20).save()
    assert bend_of(path.with_name("work.weft~")) == 10
    window.drive.editor.prefer(window.drive.editor.preferences.changed(backups=False), keep=False)
    window.bend(30).save()
    assert bend_of(path.with_name("work.weft~")) == 10
    assert sorted(file.name for file in path.parent.iterdir()) == ["work.weft", "work.weft~"]


def test_where_no_backup_can_be_kept_the_save_goes_on(path: Path) -> None:
    path.with_name("work.weft~").mkdir()
    Window(path).bend(10).save()
    assert bend_of(path) == 10


def test_a_backup_leaves_the_file_where_it_is(path: Path) -> None:
    before = path.stat().st_ino
    keep_backup(path)
    assert path.stat().st_ino == before
    assert path.with_name("work.weft~").read_bytes() == path.read_bytes()
    keep_backup(path.with_name("none.weft"))
    assert not path.with_name("none.weft~").exists()
