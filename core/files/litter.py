"""What a killed program leaves behind, and how it is swept once its owner is gone.

What is being written lies beside its place, under a name that begins with `PREFIX`, or in a folder of the system for
temporary files that begins with `SCRATCH`. Its owner holds it locked while it is alive: what is not locked is litter.
"""

import contextlib
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from core.files.ownership import hold

PREFIX = ".weft-"
SCRATCH = "weft-scratch-"
YOUNG_S = 60.0
"""What is younger may be on its way between its making and its lock."""


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """Yield a folder of the system for temporary files, which goes with the block, or is swept after a kill."""
    place = Path(tempfile.mkdtemp(prefix=SCRATCH))
    held = hold(place)
    try:
        yield place
    finally:
        shutil.rmtree(place, ignore_errors=True)
        if held is not None:
            held.release()


def sweep_scratch() -> None:
    """Remove what killed programs have left in the system's folder for temporary files."""
    _sweep(Path(tempfile.gettempdir()), SCRATCH)


def sweep(folder: Path) -> None:
    """Remove what killed programs have left beside their outputs in `folder`."""
    _sweep(folder, PREFIX)


def _sweep(folder: Path, prefix: str) -> None:
    """Remove what begins with `prefix`, belongs to the user, is not young and is held by nobody."""
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.startswith(prefix):
                _remove(Path(entry.path))


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):
        found = path.lstat()
        if not path.is_symlink() and is_own(found) and time.time() - found.st_mtime > YOUNG_S:
            held = hold(path)
            if held is not None:
                if path.is_dir():
                    shutil.rmtree(path, ignore_errors=True)
                else:
                    path.unlink()
                held.release()


def is_own(found: os.stat_result) -> bool:
    """Return whether a file belongs to the user."""
    return not hasattr(os, "getuid") or found.st_uid == os.getuid()
