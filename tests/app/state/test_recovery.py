"""Work that an earlier run left unsaved."""

import json
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from app.commands.edit import keep_at_an_end
from app.editor.editor import Editor
from app.files import document_io
from app.files.rescue_offers import offer_rescues
from app.model.jobs import Jobs
from app.model.requests import AskRecover, AskUnsaved
from app.state.recovery import Recovery
from app.tools.all import TOOLS
from core.document.project import load_project
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
        offer_rescues(self.editor)
        request = self.editor.requests.pop()
        assert isinstance(request, AskRecover)
        return request

    def close_without_saving(self) -> None:
        document_io.quit_editor(self.editor)
        request = self.editor.requests.pop()
        assert isinstance(request, AskUnsaved)
        request.then("discard")


def crashed(run: Rescued) -> None:
    """Let the editor's lock go, as the system does when a process ends, however it does."""
    if run.recovery._claim is not None:
        run.recovery._claim.release()


def kinds(folder: Path) -> list[str]:
    return sorted(file.suffix for file in folder.iterdir())


ALL = [".json", ".lock", ".png", ".weft"]


def test_unsaved_work_survives_a_crash(tmp_path: Path) -> None:
    first = Rescued(tmp_path)
    first.bend()
    first.after(1)
    assert not list(tmp_path.iterdir())
    assert first.editor.wait_s is not None
    first.after(20)
    crashed(first)
    second = Rescued(tmp_path)
    request = second.offered()
    assert [offer.name for offer in request.offers] == ["Untitled"]
    request.then(0)
    second.after(0)
    assert second.editor.document.warp.bend == 44
    assert not second.editor.history.is_saved
    assert Rescued(tmp_path).recovery.found() == []
    crashed(second)
    assert len(Rescued(tmp_path).recovery.found()) == 1


KEEPS_AND_WAITS = """
import sys, time
from pathlib import Path
from app.model.jobs import Jobs
from app.state.recovery import Recovery
from tests.app.driver import document

recovery = Recovery(Jobs.inline(), folder=Path(sys.argv[1]))
bent = document().with_warp(preset="arc", bend=44.0)
recovery.keep(bent, name="beach.jpg", project=None, source=Path("/a/beach.jpg"))
print("kept", flush=True)
time.sleep(600)
"""


def test_the_work_of_a_killed_process_is_offered_whoever_has_its_number_now(tmp_path: Path) -> None:
    command = [sys.executable, "-c", KEEPS_AND_WAITS, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[3]) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "kept\n"
        assert Rescued(tmp_path).recovery.found() == []
        other.kill()
    (note,) = tmp_path.glob("*.json")
    note.write_text(json.dumps(json.loads(note.read_text()) | {"process": os.getpid()}))
    run = Rescued(tmp_path)
    request = run.offered()
    assert [(offer.name, offer.folder) for offer in request.offers] == [("beach.jpg", "/a")]
    request.then(0)
    run.after(0)
    assert run.editor.name == "beach.jpg"
    assert run.editor.document.warp.bend == 44.0


@pytest.mark.parametrize(
    "note", [None, "", "[" * 100_000, "[]", '{"name": 5, "project": []}', '{"name": "\\udcfc"}', "\0"]
)
def test_a_rescue_without_a_good_note_is_offered_too(tmp_path: Path, note: str | None) -> None:
    run = Rescued(tmp_path)
    run.bend()
    run.after(20)
    crashed(run)
    (file,) = tmp_path.glob("*.json")
    file.unlink() if note is None else file.write_text(note)
    later = Rescued(tmp_path)
    request = later.offered()
    assert len(request.offers) == 1
    request.then(0)
    later.after(0)
    assert later.editor.document.warp.bend == 44


def test_earlier_states_are_kept_and_can_be_chosen(tmp_path: Path) -> None:
    run = Rescued(tmp_path)
    for number in range(5):
        run.editor.edit("Bend", run.editor.document.with_warp(preset="arc", bend=float(10 * number + 10)))
        run.after(20)
        for file in tmp_path.glob("*.weft"):
            aged = file.stat().st_mtime - 1000
            os.utime(file, (aged, aged))
    crashed(run)
    later = Rescued(tmp_path)
    rescues = later.recovery.found()
    assert [load_project(rescue.file).warp.bend for rescue in rescues] == [50.0, 40.0, 30.0]
    later.offered().then(2)
    later.after(0)
    assert later.editor.document.warp.bend == 30.0
    crashed(later)
    left = Rescued(tmp_path).recovery.found()
    assert [load_project(rescue.file).warp.bend for rescue in sorted(left, key=lambda rescue: rescue.generation)] == [
        30.0,
        50.0,
        40.0,
    ]


def test_states_in_quick_succession_are_one_generation(tmp_path: Path) -> None:
    run = Rescued(tmp_path)
    for number in range(5):
        run.editor.edit("Bend", run.editor.document.with_warp(preset="arc", bend=float(10 * number + 10)))
        run.after(20)
    assert [load_project(file).warp.bend for file in sorted(tmp_path.glob("*.weft"))] == [10.0, 50.0]


def test_kept_work_can_be_read_by_its_owner_only(tmp_path: Path) -> None:
    folder = tmp_path / "state"
    run = Rescued(folder)
    run.bend()
    run.after(20)
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_an_end_without_asking_keeps_what_is_not_kept_yet(tmp_path: Path) -> None:
    run = Rescued(tmp_path)
    run.bend()
    with pytest.raises(ZeroDivisionError), keep_at_an_end(run.editor):
        raise ZeroDivisionError
    crashed(run)
    (rescue,) = Rescued(tmp_path).recovery.found()
    assert load_project(rescue.file).warp.bend == 44


def test_an_end_by_closing_keeps_nothing(tmp_path: Path) -> None:
    run = Rescued(tmp_path)
    run.bend()
    with keep_at_an_end(run.editor):
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
    assert kinds(folder) == ALL


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
    assert kinds(folder) == ALL
    run.editor.project_path = tmp_path / "work.weft"
    document_io.save(run.editor)
    run.after(0)
    assert not list(folder.iterdir())
    run.editor.edit("Bend", run.editor.document.with_warp(bend=10))
    run.after(20)
    assert kinds(folder) == ALL
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
    crashed(run)
    Rescued(tmp_path).offered().then(None)
    assert not list(tmp_path.iterdir())
