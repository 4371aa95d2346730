"""Locks that die with their owner: an open, locked file, which the system lets go however a process ends.

A number of a process would not do: after a restart, or in a container, it is soon that of another one.
"""

import contextlib
import os
import sys
from pathlib import Path

if sys.platform == "win32":
    import msvcrt

    def _lock(handle: int) -> None:
        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(handle: int) -> None:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)


class Claim:
    """A lock that is held; `claim` makes one."""

    def __init__(self, path: Path, handle: int) -> None:
        self.path = path
        self._handle: int | None = handle

    def release(self, *, remove: bool = False) -> None:
        """Let go of the lock; with `remove`, and of its file, before anybody else can take it."""
        if self._handle is None:
            return
        if remove:
            with contextlib.suppress(OSError):
                self.path.unlink(missing_ok=True)
        os.close(self._handle)
        self._handle = None

    def __del__(self) -> None:
        self.release()


def claim(path: Path) -> Claim | None:
    """Lock the file `path`, which is made at need; None where somebody alive holds it.

    Raises `OSError` where the file cannot be made.
    """
    while True:
        handle = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
        try:
            _lock(handle)
        except OSError:
            os.close(handle)
            return None
        if _is_file_of(handle, path):
            return Claim(path, handle)
        os.close(handle)  # its owner has removed it meanwhile


def hold(path: Path) -> Claim | None:
    """Lock a file or folder that is there; None where somebody alive holds it, or it cannot be locked."""
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_CLOEXEC", 0))
    except OSError:
        return None
    try:
        _lock(handle)
    except OSError:
        os.close(handle)
        return None
    return Claim(path, handle)


def is_claimed(path: Path) -> bool:
    """Return whether somebody alive holds the lock `path`; a lock without a file is held by nobody."""
    if not path.exists():
        return False
    try:
        held = claim(path)
    except OSError:
        return False
    if held is None:
        return True
    held.release()
    return False


def _is_file_of(handle: int, path: Path) -> bool:
    """Return whether `path` still leads to the open file."""
    try:
        found, opened = path.stat(), os.fstat(handle)
    except OSError:
        return False
    return (found.st_dev, found.st_ino) == (opened.st_dev, opened.st_ino)
