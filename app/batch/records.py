"""What is done: a small file for every frame, or chunk of a video, that appears together with what it tells of.

A frame is done while its record is there, was made by the same recipe from the same inputs, and its output still is
there. Both come to their places together, whenever the program is killed: so nothing is half done, and nothing that is
done is done again.
"""

import contextlib
import json
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Literal, TypeAlias

from app.batch.plan import Batch, Chunk, Item
from core.arrays import InputError
from core.files.atomic import AtomicFiles
from core.files.journal import complete, tidy
from core.files.json_file import read_json
from core.files.ownership import claim

State: TypeAlias = Literal["done", "kept", "failed"]
_WAIT_S = 0.2
JOINED = "joined"
"""Name of the record of a whole video."""


@dataclass(frozen=True)
class Row:
    """What became of a frame: one line of the result table."""

    frame: int
    source: str
    output: str
    state: State
    """`kept` is what an earlier run has done."""
    seconds: float = 0.0
    fault: str = ""
    notes: list[str] = field(default_factory=list)


def fresh(chunks: Iterable[Chunk]) -> None:
    """Forget what earlier runs have done of these chunks."""
    for chunk in chunks:
        for name in [JOINED, chunk.name, *(frame_name(item) for item in chunk.items)]:
            (chunk.batch.records / f"{name}.json").unlink(missing_ok=True)


def settle(batch: Batch, chunk: Chunk) -> None:
    """Complete what a kill has left between two files."""
    folders = {batch.records, *(Path(item.output).parent for item in chunk.items)}
    for step in (complete, tidy):  # nothing is swept before all is completed: what a journal names lies in two folders
        for folder in folders:
            step(folder)


@contextmanager
def hold_back(batch: Batch, name: str) -> Iterator[None]:
    """Hold a part of the batch alone; who comes second waits until the first is done, or gone."""
    batch.records.mkdir(parents=True, exist_ok=True)
    path = batch.records / f"{name}.lock"
    while (lock := claim(path)) is None:
        time.sleep(_WAIT_S)
    try:
        yield
    finally:
        lock.release(remove=True)


def frame_name(item: Item) -> str:
    """Return the name of the record of a frame that is a file of its own."""
    return f"frame-{item.frame:07d}"


def done(batch: Batch, name: str, outputs: Iterable[Path]) -> list[Row] | None:
    """Return the rows of the record `name` as those of an earlier run, None unless all it tells of is done."""
    try:
        found = read_json(batch.records / f"{name}.json")
        rows = [Row(**row) for row in found["rows"]]
        stale = found["digest"] != batch.digest or found["inputs"] != stamps(found["inputs"])
    except (InputError, TypeError, KeyError, AttributeError):
        return None
    if stale or any(row.state != "done" for row in rows) or not all(path.is_file() for path in outputs):
        return None
    return [replace(row, state="kept") for row in rows]


def note(files: AtomicFiles, batch: Batch, name: str, rows: Sequence[Row], inputs: Iterable[str]) -> None:
    """Have the record `name` appear with the other `files`."""
    text = json.dumps(
        {"digest": batch.digest, "inputs": stamps(inputs), "rows": [asdict(row) for row in rows]}, indent=1
    )
    with files.place(batch.records / f"{name}.json") as place:
        place.write_text(f"{text}\n", encoding="utf-8")


def stamps(paths: Iterable[str]) -> dict[str, str]:
    """Return size in bytes and time of change in nanoseconds of files, nothing for one that is not there."""
    found = dict.fromkeys(paths, "")
    for path in found:
        with contextlib.suppress(OSError):
            state = Path(path).stat()
            found[path] = f"{state.st_size} {state.st_mtime_ns}"
    return found
