"""What each stage from lattice to pixels is worth on photographs of patterned cloth.

The cloth of each photo is found once, in its matte, and split with all stages, then without each of some by turns.
"""

import sys
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from app.bench.photographs import LEAST_COVERED, LEAST_LIKENESS, cloth_of, photographs_in, score
from core.arrays import InputError
from core.imaging.images import load
from core.linalg.blas import one_thread
from core.overlay.compositing import encode, searchable
from core.overlay.decomposition import find, split
from core.overlay.detection.seeding import NoPatternError
from core.overlay.pixels.stages import OPTIONAL
from core.progress import run

Record: TypeAlias = dict[str, Any]

EACH = "each"
"""Stands for every stage that can be left out, by turns."""
WHOLE = "nothing"
"""What is left out of the splitting that all others are compared with."""


def measure(folder: Path, stages: Collection[str]) -> list[Record]:
    """Return one record per photo and stage that is left out: half, 0 or 1, and scores; nothing is left out first."""
    unknown = next((name for name in stages if name not in (*OPTIONAL, EACH)), None)
    if unknown is not None:
        raise InputError(f"--without {unknown}: not one of {EACH}, {', '.join(OPTIONAL)}")
    wanted = OPTIONAL if EACH in stages else tuple(stages)
    return [
        record
        for number, file in enumerate(photographs_in(folder))
        for record in _records(file, number % 2, (WHOLE, *wanted))
    ]


def summarise(records: list[Record]) -> list[Record]:
    """Return for every stage that is left out what that changes of the means over the photos, of each half and of both.

    The first row has the means themselves.
    """
    names = list(dict.fromkeys(record["without"] for record in records))
    rows: list[Record] = []
    for name in names:
        row: Record = {"without": name}
        for score_name in ("holds", "covers", "likeness", "explains"):
            for half, label in ((0, "_0"), (1, "_1"), (None, "")):
                if label and score_name != "explains":
                    continue
                mean, whole = (_mean(records, stage, score_name, half) for stage in (name, WHOLE))
                row[score_name + label] = mean if name == WHOLE else mean - whole
        rows.append(row)
    return rows


def _mean(records: list[Record], name: str, score_name: str, half: int | None) -> float:
    found = [r[score_name] for r in records if r["without"] == name and (half is None or r["half"] == half)]
    return float(np.mean(found)) if found else float("nan")


def _records(file: Path, half: int, names: tuple[str, ...]) -> Iterator[Record]:
    image, cloth = load(file), cloth_of(file)
    try:
        found = run(find(encode(image), region=searchable(image, cloth)))
    except NoPatternError:
        return
    for name in names:
        try:
            with one_thread():
                scores = score(image, cloth, split(found, without=(name,)))
        except NoPatternError:
            scores = {"covers": 0.0, "spills": 0.0, "likeness": 0.0, "explains": 0.0}
        holds = scores["covers"] >= LEAST_COVERED and scores["likeness"] >= LEAST_LIKENESS
        if sys.stderr.isatty():
            sys.stderr.write(f"{file.stem} without {name}: explains {scores['explains']:.3f}\n")
        yield {"name": file.stem, "half": half, "without": name, **scores, "holds": holds}
