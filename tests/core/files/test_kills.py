"""Killed in the middle of writing: files and sets of files are there whole, and what was left behind is swept."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from core.files import litter
from core.files.atomic import AtomicFiles, atomic_folder, write_text
from core.files.journal import tidy
from core.files.litter import scratch_folder, sweep_scratch

ROOT = Path(__file__).parents[3]
NAMES = ("a.txt", "b.txt", "c.txt")

WRITES = """
import os, signal, sys
from pathlib import Path
from core.files.atomic import AtomicFiles, atomic_folder
from tests.killing import kill_before_move

kind, folder = sys.argv[2], Path(sys.argv[3])
kill_before_move(int(sys.argv[1]))
if kind == "set":
    with AtomicFiles() as files:
        for name in ("a.txt", "b.txt", "c.txt"):
            with files.place(folder / name) as place:
                place.write_text("new")
else:
    with atomic_folder(folder / "parts") as parts:
        for name in ("a.txt", "b.txt", "c.txt"):
            (parts / name).write_text("new")
        if kind == "killed within":
            os.kill(os.getpid(), signal.SIGKILL)
"""


def killed(kind: str, folder: Path, moves: int) -> None:
    """Write in another process, which is killed before its move number `moves`, or comes to its end."""
    done = subprocess.run([sys.executable, "-c", WRITES, str(moves), kind, str(folder)], cwd=ROOT, check=False)
    assert done.returncode in (0, -signal.SIGKILL)


def texts(folder: Path) -> dict[str, str]:
    return {file.name: file.read_text() for file in folder.iterdir() if file.is_file()}


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sweep also what is young."""
    monkeypatch.setattr(litter, "YOUNG_S", -1.0)


@pytest.mark.parametrize("moves", range(4))
def test_a_set_that_was_killed_between_its_files_is_completed_by_whoever_comes_next(tmp_path: Path, moves: int) -> None:
    for name in NAMES:
        (tmp_path / name).write_text("old")
    killed("set", tmp_path, moves)
    write_text(tmp_path / "d.txt", "another")
    assert texts(tmp_path) == dict.fromkeys(NAMES, "new") | {"d.txt": "another"}


@pytest.mark.parametrize("kind", ["folder", "killed within"])
@pytest.mark.parametrize("moves", range(3))
def test_a_folder_over_an_older_one_is_the_one_or_the_other(tmp_path: Path, kind: str, moves: int) -> None:
    parts = tmp_path / "parts"
    parts.mkdir()
    for name in (*NAMES, "kept.txt"):
        (parts / name).write_text("old")
    killed(kind, tmp_path, moves)
    state = texts(parts)
    assert state.pop("kept.txt") == "old"
    assert state in (dict.fromkeys(NAMES, "old"), dict.fromkeys(NAMES, "new"))
    tidy(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["parts"]


def test_a_folder_keeps_what_it_has_beside_the_new_files(tmp_path: Path) -> None:
    (tmp_path / "parts" / "inner").mkdir(parents=True)
    (tmp_path / "parts" / "a.txt").write_text("old")
    (tmp_path / "parts" / "inner" / "x.txt").write_text("kept")
    with atomic_folder(tmp_path / "parts") as parts:
        (parts / "a.txt").write_text("new")
    assert texts(tmp_path / "parts") == {"a.txt": "new"}
    assert texts(tmp_path / "parts" / "inner") == {"x.txt": "kept"}
    assert [file.name for file in tmp_path.iterdir()] == ["parts"]


def test_what_is_being_written_is_not_swept(tmp_path: Path) -> None:
    with AtomicFiles() as files:
        with files.place(tmp_path / "a.txt") as place:
            place.write_text("new")
        tidy(tmp_path)
        assert place.exists()
    with atomic_folder(tmp_path / "parts") as parts:
        tidy(tmp_path)
        (parts / "a.txt").write_text("new")
    assert texts(tmp_path) == {"a.txt": "new"}
    assert texts(tmp_path / "parts") == {"a.txt": "new"}


def test_only_what_is_ours_nobodys_and_old_is_swept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(litter, "YOUNG_S", 60.0)
    for name in (".weft-old.png", ".weft-young.png", ".other.png"):
        (tmp_path / name).write_text("x")
    (tmp_path / ".weft-link").symlink_to(tmp_path / ".other.png")
    aged = time.time() - 1000
    os.utime(tmp_path / ".weft-old.png", (aged, aged))
    os.utime(tmp_path / ".other.png", (aged, aged))
    tidy(tmp_path)
    assert sorted(file.name for file in tmp_path.iterdir()) == [".other.png", ".weft-link", ".weft-young.png"]


def test_folders_for_temporary_files_are_swept_once_their_owner_is_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    code = "import os; from core.files.litter import scratch_folder\nwith scratch_folder(): os.kill(os.getpid(), 9)"
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=environment, check=False)
    assert len(list(tmp_path.iterdir())) == 1
    with scratch_folder() as alive:
        sweep_scratch()
        assert list(tmp_path.iterdir()) == [alive]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["", "[", "[[1, 2]]", "[5]", '[["/etc/hostname", "/tmp/x"]]', "[" * 100_000])
def test_a_journal_that_is_not_whole_moves_nothing(tmp_path: Path, text: str) -> None:
    (tmp_path / ".weft-x.journal").write_text(text)
    (tmp_path / "a.txt").write_text("old")
    tidy(tmp_path)
    assert texts(tmp_path) == {"a.txt": "old"}


def test_a_journal_moves_only_what_lies_beside_its_place(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    moves = [[str(tmp_path / "mine.txt"), str(tmp_path / "stolen.txt")]]
    (tmp_path / ".weft-x.journal").write_text(json.dumps(moves))
    tidy(tmp_path)
    assert texts(tmp_path) == {"mine.txt": "mine"}


def test_random_kills_do_no_harm() -> None:
    command = [sys.executable, "-m", "tests.fuzz.kills", "--count", "40", "--seed", "3"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
