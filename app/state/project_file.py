"""What a project's file was when this editor read or wrote it last, to tell when somebody else has written it."""

import contextlib
import os
import shutil
from pathlib import Path
from typing import TypeAlias

from core.arrays import InputError

Stamp: TypeAlias = tuple[int, int, int]
"""Number, size in bytes and time of change in nanoseconds of a file."""
BACKUP = "~"
"""Ending of the name of the version before."""


class ChangedOnDiskError(InputError):
    """Somebody else has written the project's file since it was opened here."""


class OnDisk:
    """The files as they were seen last, by path; shared with the thread that writes them."""

    def __init__(self) -> None:
        self._seen: dict[Path, Stamp] = {}

    def note(self, path: Path) -> None:
        """Remember the file as it is now; it was read or written here."""
        stamp = _stamp(path)
        if stamp is not None:
            self._seen[_key(path)] = stamp

    def check(self, path: Path) -> None:
        """Raise `ChangedOnDiskError` if the file is there and is not the one that was seen last."""
        seen, found = self._seen.get(_key(path)), _stamp(path)
        if seen is not None and found is not None and seen != found:
            raise ChangedOnDiskError(f"{path}: was changed by another program")


def keep_backup(path: Path) -> None:
    """Keep the present version of a file beside it, as `name~`; the file itself stays where it is throughout.

    A place that takes no second file keeps none: the save itself says what is wrong with the place.
    """
    backup = path.with_name(f"{path.name}{BACKUP}")
    aside = path.with_name(f".{path.name[:40]}{os.getpid()}{BACKUP}")
    with contextlib.suppress(OSError):
        if not path.is_file() or (backup.exists() and not backup.is_file()):
            return
        aside.unlink(missing_ok=True)
        try:
            aside.hardlink_to(path.resolve())
        except OSError:  # a file system without links
            shutil.copy2(path, aside)
        aside.replace(backup)
    with contextlib.suppress(OSError):
        aside.unlink(missing_ok=True)


def _stamp(path: Path) -> Stamp | None:
    try:
        found = path.stat()
    except (OSError, ValueError):
        return None
    return found.st_ino, found.st_size, found.st_mtime_ns


def _key(path: Path) -> Path:
    try:
        return path.resolve()
    except (OSError, RuntimeError):
        return path
