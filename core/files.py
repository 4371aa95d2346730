"""Files and folders that appear whole or not at all.

What is written goes beside its place first and is moved there when it is complete, so that a fault, a full disk or an
interrupt leaves what was there before.
"""

import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from core.arrays import InputError


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yield the place to write to; move it to `path` when the block ends without a fault.

    The place has the suffix of `path` and lies in the same folder. A device or a pipe cannot be replaced: it is fed
    with the finished file instead. Raises `InputError` naming `path` for any `OSError` of the block.
    """
    with _faults_named(path):
        target = path.resolve()
        if target.is_dir():
            raise InputError(f"{path}: is a folder, not a file")
        replaceable = not target.exists() or target.is_file()
        handle, name = tempfile.mkstemp(
            dir=target.parent if replaceable else None, prefix=f".{target.stem[:40]}-", suffix=target.suffix
        )
        os.close(handle)
        place = Path(name)
        try:
            yield place
            if replaceable:
                place.chmod(_mode(target))
                _flush(place)
                place.replace(target)
            else:
                _feed(place, target)
        finally:
            place.unlink(missing_ok=True)


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """Yield an empty folder to fill; move what it holds to the folder `path` when the block ends without a fault.

    Files of the same name in an existing `path` are replaced, others stay. Raises `InputError` naming `path` for any
    `OSError` of the block.
    """
    with _faults_named(path):
        target = path.resolve()
        if target.exists() and not target.is_dir():
            raise InputError(f"{path}: is a file, not a folder")
        place = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name[:40]}-"))
        try:
            yield place
            if target.exists():
                for file in sorted(place.iterdir()):
                    file.replace(target / file.name)
            else:
                place.chmod(0o777 & ~_umask())
                place.replace(target)
        finally:
            shutil.rmtree(place, ignore_errors=True)


def check_place(path: Path) -> None:
    """Raise `InputError` if no file could be written at `path`: to be asked before the work that fills it."""
    if path.is_dir():
        raise InputError(f"{path}: is a folder, not a file")
    _try_beside(path)


def check_folder_place(path: Path) -> None:
    """Raise `InputError` if no folder could be written at `path`: to be asked before the work that fills it."""
    if path.exists() and not path.is_dir():
        raise InputError(f"{path}: is a file, not a folder")
    _try_beside(path)


def write_bytes(path: Path, data: bytes) -> None:
    """Write `data` to `path`, whole or not at all."""
    with atomic_file(path) as place:
        place.write_bytes(data)


def write_text(path: Path, text: str) -> None:
    """Write `text` to `path` as UTF-8, whole or not at all."""
    write_bytes(path, text.encode("utf-8"))


def _try_beside(path: Path) -> None:
    """Raise `InputError` naming `path` if its folder takes no new file; a device or a pipe needs none."""
    target = path.resolve()
    if not target.parent.is_dir():
        raise InputError(f"{path}: there is no folder {target.parent}")
    if not target.exists() or target.is_file() or target.is_dir():
        with _faults_named(path), tempfile.TemporaryFile(dir=target.parent):
            pass


@contextmanager
def _faults_named(path: Path) -> Iterator[None]:
    """Turn an `OSError` of the block into an `InputError` that names `path`."""
    try:
        yield
    except OSError as fault:
        raise InputError(f"{path}: {(fault.strerror or str(fault)).lower()}") from fault


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


def _feed(place: Path, target: Path) -> None:
    """Copy `place` into the device or pipe `target`."""
    with place.open("rb") as source, target.open("wb") as sink:
        shutil.copyfileobj(source, sink)
