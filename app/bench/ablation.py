"""What each stage from lattice to pixels is worth on photographs of patterned cloth.

The cloth of each photo is found once, in its matte, and split with all stages, then without each of some by turns.
"""

import sys
from collections.abc import Collection
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from app.bench.photographs import LEAST_COVERED, LEAST_LIKENESS, SCORES, cloth_of, photographs_in, score
from core.arrays import InputError
from core.imaging.images import load
from core.linalg.blas import one_thread
from core.overlay.decomposition import find, split_without
from core.overlay.detection.seeding import NoPatternError
from core.overlay.laying.compositing import encode, searchable
from core.overlay.pixels.stages import OPTIONAL, WHOLE
from core.progress import run

Record: TypeAlias = dict[str, Any]

EACH = "each"
"""Stands for every stage that can be left out, by turns."""


def measure(folder: Path, stages: Collection[str]) -> list[Record]:
    """Return one record per photo and stage that is left out: half, 0 or 1, and scores; then without none."""
    unknown = next((name for name in stages if name not in (*OPTIONAL, EACH)), None)
    if unknown is not None:
        raise InputError(f"--without {unknown}: not one of {EACH}, {', '.join(OPTIONAL)}")
    wanted = OPTIONAL if EACH in stages else tuple(stages)
    return [
        record for number, file in enumerate(photographs_in(folder)) for record in _records(file, number % 2, wanted)
    ]


def summarise(records: list[Record]) -> list[Record]:
    """Return for every stage that is left out what that changes of the means over the photos, of each half and of both.

    The first row has the means themselves.
    """
    names = [WHOLE, *dict.fromkeys(r["without"] for r in records if r["without"] != WHOLE)]
    rows: list[Record] = []
    for name in names:
        row: Record = {"without": name}
        for score_name in ("holds", "covers", "likeness", "explains", "jumbled"):
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


def _records(file: Path, half: int, names: Collection[str]) -> list[Record]:
    image, cloth = load(file), cloth_of(file)
    try:
        found = run(find(encode(image), region=searchable(image, cloth)))
    except NoPatternError:
        return []
    records: list[Record] = []
    with one_thread():
        for name, split in split_without(found, names):
            scores = dict.fromkeys(SCORES, 0.0) if split is None else score(image, cloth, split)
            holds = scores["covers"] >= LEAST_COVERED and scores["likeness"] >= LEAST_LIKENESS
            records.append({"name": file.stem, "half": half, "without": name, **scores, "holds": holds})
    if sys.stderr.isatty():
        sys.stderr.write(f"{file.stem}: explains {records[-1]['explains']:.3f}\n")
    return records
