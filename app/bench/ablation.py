"""What each stage of the search, and from lattice to pixels, is worth on photographs of patterned cloth.

The cloth of each photo is found in its matte, and split with all stages, then without each of some by turns. Without a
stage of the search it is found anew, where the search comes to that stage at all.
"""

import sys
from collections.abc import Collection
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from app.bench.photographs import LEAST_COVERED, LEAST_LIKENESS, SCORES, cloth_of, photographs_in, score
from app.bench.search_stages import SEARCH_STAGES, replaced, watched
from core.arrays import Bools, InputError
from core.imaging.images import Image, load
from core.linalg.blas import one_thread
from core.overlay.cloth_search import Known, find_all
from core.overlay.decomposition import Decomposition, split, split_without
from core.overlay.detection.seeding import NoPatternError
from core.overlay.found_cloth import choose
from core.overlay.laying.compositing import encode, searchable
from core.overlay.pixels.stages import OPTIONAL, WHOLE
from core.progress import run

Record: TypeAlias = dict[str, Any]

EACH = "each"
"""Stands for every stage that can be left out, by turns."""


def measure(folder: Path, stages: Collection[str]) -> list[Record]:
    """Return one record per photo and stage that is left out: half, 0 or 1, and scores; then without none."""
    every = (*SEARCH_STAGES, *OPTIONAL)
    unknown = next((name for name in stages if name not in (*every, EACH)), None)
    if unknown is not None:
        raise InputError(f"--without {unknown}: not one of {EACH}, {', '.join(every)}")
    wanted = every if EACH in stages else tuple(stages)
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
        with watched() as reached:
            found = choose(run(find_all(encode(image), Known(searchable(image, cloth)))))
    except NoPatternError:
        return []
    with one_thread():
        scores = {name: _score(image, cloth, parts) for name, parts in split_without(found, names)}
    for name in (name for name in names if name in SEARCH_STAGES):
        scores[name] = scores[WHOLE]
        if name in reached:
            with replaced(name, SEARCH_STAGES[name].instead):
                scores[name] = _score_anew(image, cloth)
    if sys.stderr.isatty():
        sys.stderr.write(f"{file.stem}: explains {scores[WHOLE]['explains']:.3f}\n")
    return [{"name": file.stem, "half": half, "without": name, **scores[name]} for name in (*names, WHOLE)]


def _score_anew(image: Image, cloth: Bools | None) -> Record:
    """Return the scores of a photo whose cloth is found as the search now is."""
    try:
        found = choose(run(find_all(encode(image), Known(searchable(image, cloth)))))
        with one_thread():
            return _score(image, cloth, split(found))
    except NoPatternError:
        return _score(image, cloth, None)


def _score(image: Image, cloth: Bools | None, parts: Decomposition | None) -> Record:
    scores = dict.fromkeys(SCORES, 0.0) if parts is None else score(image, cloth, parts)
    return {**scores, "holds": scores["covers"] >= LEAST_COVERED and scores["likeness"] >= LEAST_LIKENESS}
