"""Files and folders that appear whole or not at all.

What is written goes beside its place first and is moved there when it is complete, so that a fault, a full disk or an
interrupt leaves what was there before.
"""

import os
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Self

from core.arrays import InputError
from core.files.exchange import exchange
from core.files.faults import system_faults_named
from core.files.journal import flush_folder, journal, tidy
from core.files.litter import PREFIX
from core.files.ownership import Claim, hold


class AtomicFiles:
    """Several files that appear together: none of them before all are whole.

    As a context manager it moves what was written under `place` when its block ends without a fault. A device or a pipe
    cannot be replaced: it is fed with the finished file, before any other is moved.
    """

    def __init__(self) -> None:
        self._begun: list[tuple[Path, Claim | None]] = []
        self._whole: list[tuple[Path, Path, Path]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        try:
            if kind is None:
                self._move_all()
        finally:
            for place, held in self._begun:
                place.unlink(missing_ok=True)
                if held is not None:
                    held.release()

    def _move_all(self) -> None:
        """Feed devices and pipes, then move the files to their places."""
        files = sorted(self._whole, key=lambda file: _is_replaceable(file[2]))
        moved = [file for file in files if _is_replaceable(file[2])]
        for path, place, target in files[: len(files) - len(moved)]:
            with system_faults_named(path):
                _feed(place, target)
        with system_faults_named(moved[0][0]) if moved else nullcontext(), journal([file[1:] for file in moved]):
            for path, place, target in moved:
                with system_faults_named(path):
                    place.replace(target)
                    flush_folder(target.parent)

    @contextmanager
    def place(self, path: Path) -> Iterator[Path]:
        """Yield the place to write the file `path` to, in the same folder and with the same suffix.

        Raises `InputError` naming `path` for any `OSError` of the block.
        """
        with system_faults_named(path):
            target = _resolve(path)
            if target.is_dir():
                raise InputError(f"{path}: is a folder, not a file")
            folder = target.parent if _is_replaceable(target) else None
            if folder is not None:
                tidy(folder)
            handle, name = tempfile.mkstemp(dir=folder, prefix=f"{PREFIX}{target.stem[:40]}-", suffix=target.suffix)
            os.close(handle)
            place = Path(name)
            self._begun.append((place, hold(place)))
            yield place
            place.chmod(_mode(target))
            _flush(place)
            self._begun.append((place, hold(place)))  # whoever wrote it may have put another file there
            self._whole.append((path, place, target))


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yield the place to write the file `path` to; move it there when the block ends without a fault.

    Raises `InputError` naming `path` for any `OSError` of the block.
    """
    with AtomicFiles() as files, files.place(path) as place:
        yield place


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """Yield an empty folder to fill; move what it holds to the folder `path` when the block ends without a fault.

    Files of the same name in an existing `path` are replaced, others stay. Raises `InputError` naming `path` for any
    `OSError` of the block.
    """
    with system_faults_named(path):
        target = _resolve(path)
        if target.exists() and not target.is_dir():
            raise InputError(f"{path}: is a file, not a folder")
        tidy(target.parent)
        place = Path(tempfile.mkdtemp(dir=target.parent, prefix=f"{PREFIX}{target.name[:40]}-"))
        held = hold(place)
        try:
            yield place
            for file in place.iterdir():
                _flush(file)
            if not target.exists():
                place.chmod(0o777 & ~_umask())
                place.replace(target)
            elif not (_takes_along(target, place) and exchange(place, target)):
                for file in sorted(place.iterdir()):
                    file.replace(target / file.name)
            flush_folder(target.parent)
        finally:
            shutil.rmtree(place, ignore_errors=True)
            if held is not None:
                held.release()


def _takes_along(old: Path, new: Path) -> bool:
    """Give the folder `new` the files of `old` that it has not, and its permissions; say whether that was possible."""
    try:
        new.chmod(stat.S_IMODE(old.stat().st_mode))
        for file in old.iterdir():
            there = new / file.name
            if not there.exists() or not file.is_file() or file.is_symlink():
                there.hardlink_to(file)
    except OSError:  # such as for a folder within, or a file system without links
        return False
    return True


def check_place(path: Path) -> None:
    """Raise `InputError` if no file could be written at `path`: to be asked before the work that fills it."""
    with system_faults_named(path):
        if path.is_dir():
            raise InputError(f"{path}: is a folder, not a file")
        _try_beside(path)


def check_folder_place(path: Path) -> None:
    """Raise `InputError` if no folder could be written at `path`: to be asked before the work that fills it."""
    with system_faults_named(path):
        if path.exists() and not path.is_dir():
            raise InputError(f"{path}: is a file, not a folder")
        _try_beside(path)


def check_outputs(outputs: Iterable[Path | None], *, beside: Iterable[Path | None] = ()) -> None:
    """Raise `InputError` unless each of the `outputs` can be written, to a file of its own.

    `beside` are files that must not be written over. None is an option that was not given.
    """
    read = {_identity(path) for path in beside if path is not None}
    taken: dict[object, Path] = {}
    for path in outputs:
        if path is None:
            continue
        check_place(path)
        identity = _identity(path)
        if identity in read:
            raise InputError(f"{path}: would be written over, but another option names it")
        if identity in taken and (path.is_file() or not path.exists()):
            raise InputError(f"{path}: two outputs go to the same file")
        taken[identity] = path


def write_bytes(path: Path, data: bytes) -> None:
    """Write `data` to `path`, whole or not at all."""
    with atomic_file(path) as place:
        place.write_bytes(data)


def write_text(path: Path, text: str) -> None:
    """Write `text` to `path` as UTF-8, whole or not at all."""
    write_bytes(path, text.encode("utf-8"))


def _try_beside(path: Path) -> None:
    """Raise `InputError` naming `path` if its folder takes no new file; a device or a pipe needs none."""
    target = _resolve(path)
    if not target.parent.is_dir():
        raise InputError(f"{path}: there is no folder {target.parent}")
    if not target.exists() or target.is_file() or target.is_dir():
        with tempfile.TemporaryFile(dir=target.parent):
            pass


def _resolve(path: Path) -> Path:
    """Return `path` without links; raise `InputError` if they lead to one another."""
    try:
        target = path.resolve()
    except RuntimeError:  # before Python 3.13
        target = path
    if target.is_symlink():
        raise InputError(f"{path}: too many levels of symbolic links")
    with suppress(FileNotFoundError, NotADirectoryError):
        target.lstat()  # raises what `exists` does not say from Python 3.14 on, such as a name that is too long
    return target


def _identity(path: Path) -> object:
    """Return what two paths have in common if they lead to one file, linked or not."""
    with system_faults_named(path):
        target = _resolve(path)
        if not target.exists():
            return target
        found = target.stat()
        return found.st_dev, found.st_ino


def _mode(target: Path) -> int:
    """Return the permissions that `target` has, or those that a new file gets."""
    return stat.S_IMODE(target.stat().st_mode) if target.exists() else 0o666 & ~_umask()


def _umask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


def _flush(place: Path) -> None:
    """Have the disk accept all of `place`, so that a full one is noticed before the move."""
    with place.open("rb") as file:
        os.fsync(file.fileno())


def _is_replaceable(target: Path) -> bool:
    return target.is_file() or not target.exists()


def _feed(place: Path, target: Path) -> None:
    """Copy `place` into a device or a pipe."""
    with place.open("rb") as source, target.open("wb") as sink:
        shutil.copyfileobj(source, sink)
