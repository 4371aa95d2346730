"""Work that an earlier run left unsaved."""

import json
from pathlib import Path

import pytest

from app import filing
from app.commands.edit import kept_at_an_end
from app.editor import Editor
from app.jobs import Jobs
from app.recovery import Recovery
from app.requests import AskRecover, AskUnsaved
from app.tools.all import TOOLS
from core.project import load_project
from tests.app.driver import Clock, document


class Rescued:
    """An editor that keeps unsaved work in a folder."""

    def __init__(self, folder: Path) -> None:
        self.clock = Clock()
        jobs = Jobs.inline()
        self.recovery = Recovery(jobs, folder=folder)
        self.editor = Editor(document(), TOOLS, jobs=jobs, recovery=self.recovery, clock=self.clock)

    def after(self, seconds: float) -> None:
        self.editor.update()
        self.clock.now += seconds
        self.editor.update()
        self.editor.update()

    def bend(self) -> None:
        self.editor.edit("Bend", self.editor.document.with_warp(preset="arc", bend=44))

    def offered(self) -> AskRecover:
        filing.offer_rescues(self.editor)
        request = self.editor.requests.pop()
        assert isinstance(request, AskRecover)
        return request

    def close_without_saving(self) -> None:
        filing.quit_editor(self.editor)
        request = self.editor.requests.pop()
        assert isinstance(request, AskUnsaved)
        request.then("discard")


def crashed(folder: Path) -> None:
    """Make what an editor left belong to no living process."""
    for note in folder.glob("*.json"):
        note.write_text(json.dumps(json.loads(note.read_text()) | {"process": 2**22 + 1}))


def test_unsaved_work_survives_a_crash(tmp_path: Path) -> None:
    first = Rescued(tmp_path)
    first.bend()
    first.after(1)
    assert not list(tmp_path.iterdir())
    assert first.editor.wait_s is not None
    first.after(20)
    crashed(tmp_path)
    second = Rescued(tmp_path)
    request = second.offered()
    assert request.names == ("Untitled",)
    request.then(True)
    second.after(0)
    assert second.editor.document.warp.bend == 44
    assert not second.editor.history.is_saved
    crashed(tmp_path)
    assert len(Rescued(tmp_path).recovery.found()) == 1


def test_an_end_without_asking_keeps_what_is_not_kept_yet(tmp_path: Path) -> None:
    run = Rescued(tmp_path)
    run.bend()
    with pytest.raises(ZeroDivisionError), kept_at_an_end(run.editor):
        raise ZeroDivisionError
    crashed(tmp_path)
    (rescue,) = Rescued(tmp_path).recovery.found()
    assert load_project(rescue.file).warp.bend == 44


def test_an_end_by_closing_keeps_nothing(tmp_path: Path) -> None:
    run = Rescued(tmp_path)
    run.bend()
    with kept_at_an_end(run.editor):
        run.close_without_saving()
    assert not list(tmp_path.iterdir())


def test_what_could_not_be_kept_is_tried_again(tmp_path: Path) -> None:
    folder = tmp_path / "state"
    folder.write_text("in the way")
    run = Rescued(folder)
    run.bend()
    run.after(20)
    folder.unlink()
    run.after(20)
    assert len(list(folder.iterdir())) == 2


def test_a_fault_of_keeping_is_said_until_it_succeeds(tmp_path: Path) -> None:
    folder = tmp_path / "state"
    folder.write_text("in the way")
    run = Rescued(folder)
    run.bend()
    run.after(20)
    assert run.recovery.fault is not None
    assert str(folder) in run.recovery.fault
    run.after(20)
    assert run.recovery.fault is not None
    folder.unlink()
    run.after(20)
    assert run.recovery.fault is None


def test_a_fault_of_keeping_is_forgotten_once_the_work_is_saved(tmp_path: Path) -> None:
    folder = tmp_path / "state"
    folder.write_text("in the way")
    run = Rescued(folder)
    run.bend()
    run.after(20)
    run.editor.history.mark_saved(run.editor.document)
    run.after(0)
    assert run.recovery.fault is None


def test_nothing_is_kept_of_saved_or_given_up_work(tmp_path: Path) -> None:
    folder = tmp_path / "state"
    run = Rescued(folder)
    run.bend()
    run.after(20)
    assert len(list(folder.iterdir())) == 2
    run.editor.project_path = tmp_path / "work.weft"
    filing.save(run.editor)
    run.after(0)
    assert not list(folder.iterdir())
    run.editor.edit("Bend", run.editor.document.with_warp(bend=10))
    run.after(20)
    assert len(list(folder.iterdir())) == 2
    run.close_without_saving()
    assert not list(folder.iterdir())


def test_a_running_editor_is_not_robbed(tmp_path: Path) -> None:
    run = Rescued(tmp_path)
    run.bend()
    run.after(20)
    assert Rescued(tmp_path).recovery.found() == []


def test_rescues_can_be_discarded(tmp_path: Path) -> None:
    run = Rescued(tmp_path)
    run.bend()
    run.after(20)
    crashed(tmp_path)
    Rescued(tmp_path).offered().then(False)
    assert not list(tmp_path.iterdir())
