"""The result table of a batch: one line a frame, as JSON or CSV, and the line that sums it up."""

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from app.batch.records import Row
from core.arrays import InputError
from core.files.atomic import write_text

ENDINGS = (".json", ".csv")


def check_table(path: Path | None) -> None:
    """Raise `InputError` unless a table can be written to a file of that ending."""
    if path is not None and path.suffix.lower() not in ENDINGS:
        raise InputError(f"{path}: a table is a .json or a .csv file")


def write_table(rows: Sequence[Row], path: Path) -> None:
    """Write the rows in the order of their frames."""
    rows = sorted(rows, key=lambda row: row.frame)
    write_text(path, as_json(rows) if path.suffix.lower() == ".json" else as_csv(rows))


def as_json(rows: Sequence[Row]) -> str:
    """Return the rows as a list of objects."""
    return json.dumps([asdict(row) for row in rows], indent=1) + "\n"


def as_csv(rows: Sequence[Row]) -> str:
    """Return the rows as comma-separated values with a header."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["frame", "source", "output", "state", "seconds", "fault", "notes"])
    for row in rows:
        writer.writerow([row.frame, row.source, row.output, row.state, row.seconds, row.fault, "; ".join(row.notes)])
    return text.getvalue()


def summed_up(rows: Sequence[Row], seconds: float) -> str:
    """Return how many frames came to what, in one line."""
    states = [row.state for row in rows]
    parts = [f"{states.count('done')} done"]
    parts += [f"{states.count('kept')} were done before"] if "kept" in states else []
    parts += [f"{states.count('failed')} failed"] if "failed" in states else []
    return f"{len(rows)} frames: {', '.join(parts)} in {seconds:.1f} s"
