"""Sets of files that come to their places together, also when the program is killed between two of them.

All of them are whole beside their places first. Then a journal is written that says which goes where, and then they are
moved. Whoever comes next to a folder in which a journal lies, and its writer is gone, moves the rest.
"""

import contextlib
import json
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from core.files.json_file import parse_json
from core.files.litter import PREFIX, is_own, sweep
from core.files.ownership import hold

ENDING = ".journal"


@contextmanager
def journal(moves: Sequence[tuple[Path, Path]]) -> Iterator[None]:
    """Have the `moves`, from place to target, that the block makes be completed by the next program after a kill."""
    if len(moves) < 2:
        yield
        return
    handle, name = tempfile.mkstemp(dir=moves[0][1].parent, prefix=PREFIX, suffix=ENDING)
    file = Path(name)
    held = hold(file)
    try:
        with os.fdopen(handle, "wb") as text:
            text.write(json.dumps([[str(place), str(target)] for place, target in moves]).encode("ascii"))
            text.flush()
            os.fsync(handle)
        flush_folder(file.parent)
        yield
    finally:
        file.unlink(missing_ok=True)
        if held is not None:
            held.release()


def complete(folder: Path) -> None:
    """Make the moves that killed programs have left undone in `folder`."""
    with contextlib.suppress(OSError):
        for file in folder.glob(f"{PREFIX}*{ENDING}"):
            held = hold(file)
            if held is not None and not file.is_symlink() and is_own(file.stat()):
                _move_rest(file)
                file.unlink()
                held.release()


def tidy(folder: Path) -> None:
    """Finish what killed programs have begun in `folder`, and remove what they have left."""
    complete(folder)
    sweep(folder)


def _move_rest(file: Path) -> None:
    """Move what a journal names and is still beside its place; a journal that is not whole names nothing."""
    try:
        moves = [(Path(place), Path(target)) for place, target in parse_json(file.read_bytes())]
    except (ValueError, TypeError):
        return
    for place, target in moves:
        if place.name.startswith(PREFIX) and place.exists():
            place.replace(target)
            flush_folder(target.parent)


def flush_folder(folder: Path) -> None:
    """Have the disk accept what was moved into `folder`, where the system can be asked for it."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
