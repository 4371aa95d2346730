"""Files and folders appear whole, or what was there stays."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from core.arrays import InputError
from core.files.atomic import (
    AtomicFiles,
    atomic_file,
    atomic_folder,
    check_folder_place,
    check_outputs,
    check_place,
    write_text,
)


def test_a_file_appears_whole(tmp_path: Path) -> None:
    write_text(tmp_path / "a.txt", "näh")
    assert (tmp_path / "a.txt").read_bytes() == "näh".encode()
    assert os.listdir(tmp_path) == ["a.txt"]  # noqa: PTH208  hidden files count too


def test_a_fault_leaves_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("before")

    def fail() -> None:
        with atomic_file(path) as place:
            place.write_text("half")
            assert place.suffix == ".txt"
            assert path.read_text() == "before"
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert path.read_text() == "before"
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.txt"]


def test_files_that_belong_together_appear_together(tmp_path: Path) -> None:
    a, b = tmp_path / "a.txt", tmp_path / "b.txt"
    a.write_text("before")

    def write(second: Path) -> None:
        with AtomicFiles() as files:
            with files.place(a) as place:
                place.write_text("new")
            with files.place(second) as place:
                place.write_text("new")
                assert a.read_text() == "before"

    for second, fault in ((Path("/dev/full"), "/dev/full: no space left"), (tmp_path / "no" / "b", "b: no such file")):
        with pytest.raises(InputError, match=fault):
            write(second)
        assert [(entry.name, entry.read_text()) for entry in tmp_path.iterdir()] == [("a.txt", "before")]
    write(b)
    assert {entry.name: entry.read_text() for entry in tmp_path.iterdir()} == {"a.txt": "new", "b.txt": "new"}


def test_permissions_and_links_are_kept(tmp_path: Path) -> None:
    path, link = tmp_path / "a.txt", tmp_path / "link.txt"
    path.write_text("before")
    path.chmod(0o640)
    link.symlink_to(path)
    write_text(link, "after")
    assert link.is_symlink()
    assert path.read_text() == "after"
    assert path.stat().st_mode & 0o777 == 0o640


def test_a_new_file_is_as_open_as_others(tmp_path: Path) -> None:
    write_text(tmp_path / "a.txt", "")
    (tmp_path / "b.txt").touch()
    assert (tmp_path / "a.txt").stat().st_mode == (tmp_path / "b.txt").stat().st_mode


def test_faults_of_the_disk_name_the_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no/a\.txt: no such file or directory"):
        write_text(tmp_path / "no" / "a.txt", "")
    with pytest.raises(InputError, match="is a folder, not a file"):
        write_text(tmp_path, "")
    with pytest.raises(InputError, match="no space left on device"):
        write_text(Path("/dev/full"), "text")
    assert Path("/dev/full").is_char_device()


def test_a_pipe_is_fed(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_text(pipe, "text")
    assert os.read(reader, 99) == b"text"
    os.close(reader)


def test_a_folder_appears_whole(tmp_path: Path) -> None:
    target = tmp_path / "out"

    def fail() -> None:
        with atomic_folder(target) as place:
            (place / "a").touch()
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert not list(tmp_path.iterdir())
    with atomic_folder(target) as place:
        (place / "a").write_text("1")
        assert not target.exists()
    assert [entry.name for entry in tmp_path.rglob("*")] == ["out", "a"]


def test_a_folder_that_is_there_keeps_its_other_files(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("old")
    (tmp_path / "b").write_text("mine")
    with atomic_folder(tmp_path) as place:
        (place / "a").write_text("new")
    assert {entry.name: entry.read_text() for entry in tmp_path.iterdir()} == {"a": "new", "b": "mine"}
    with pytest.raises(InputError, match="is a file, not a folder"), atomic_folder(tmp_path / "a"):
        pass


def test_a_place_is_judged_before_the_work(tmp_path: Path) -> None:
    check_place(tmp_path / "a.txt")
    with pytest.raises(InputError, match="is a folder, not a file"):
        check_place(tmp_path)
    with pytest.raises(InputError, match=r"a\.txt: there is no folder .*/no"):
        check_place(tmp_path / "no" / "a.txt")
    check_folder_place(tmp_path)
    check_folder_place(tmp_path / "new")
    (tmp_path / "a.txt").write_text("kept")
    with pytest.raises(InputError, match="is a file, not a folder"):
        check_folder_place(tmp_path / "a.txt")
    with pytest.raises(InputError, match="there is no folder"):
        check_folder_place(tmp_path / "no" / "new")
    assert os.listdir(tmp_path) == ["a.txt"]  # noqa: PTH208


def test_a_folder_that_takes_no_files_is_noticed_before_the_work() -> None:
    for check in (check_place, check_folder_place):
        with pytest.raises(InputError, match=r"^/proc/a: "):
            check(Path("/proc/a"))
    check_place(Path("/dev/null"))


@pytest.mark.parametrize("check", [check_place, check_folder_place, lambda path: check_outputs([path])])
def test_names_that_lead_nowhere_are_named(check: Callable[[Path], None], tmp_path: Path) -> None:
    circle, long = tmp_path / "circle.png", tmp_path / ("x" * 300 + ".png")
    circle.symlink_to(circle)
    with pytest.raises(InputError, match=r"circle\.png: .*symbolic links"):
        check(circle)
    with pytest.raises(InputError, match=r"x\.png: file name too long"):
        check(long)


def test_every_output_needs_a_file_of_its_own(tmp_path: Path) -> None:
    a, b, link, other_name = (tmp_path / name for name in ("a", "b", "link", "other"))
    a.write_text("mine")
    link.symlink_to(a)
    other_name.hardlink_to(a)
    check_outputs([a, None, b], beside=[None, tmp_path / "c"])
    for path in (a, link, other_name, tmp_path / "." / "a"):
        with pytest.raises(InputError, match="two outputs go to the same file"):
            check_outputs([a, path])
        with pytest.raises(InputError, match=f"{path.name}: would be written over, but another option names it"):
            check_outputs([b, path], beside=[a])
    with pytest.raises(InputError, match="two outputs go to the same file"):
        check_outputs([b, b])
    check_outputs([Path("/dev/null"), Path("/dev/null")])
    assert a.read_text() == "mine"
