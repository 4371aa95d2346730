"""Every malformed file that was ever answered wrongly is answered rightly, and so are some new ones of each kind."""

import json
from pathlib import Path

import pytest

from tests.fuzz.readers import READERS, answers, scratch

KEPT = json.loads(Path(__file__).with_name("kept.json").read_text())
FRESH = 12_000
"""So many more files of each kind, the first of their numbers."""
FEWER = {"project": 1200, "folder": 4000}
"""Of kinds that take longer to make and read."""


@pytest.mark.parametrize(("name", "seed"), [(name, seed) for name, seeds in KEPT.items() for seed in seeds])
def test_a_file_that_was_answered_wrongly_is_answered_rightly(name: str, seed: int, tmp_path: Path) -> None:
    answers(READERS[name], seed, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_malformed_files_are_read_or_refused_in_one_line(name: str) -> None:
    faults: dict[str, str] = {}
    with scratch() as folder:
        for seed in range(FEWER.get(name, FRESH)):
            try:
                answers(READERS[name], seed, Path(folder))
            except Exception as fault:  # noqa: BLE001  each is what is looked for
                faults[f"{name}:{seed}"] = repr(fault)
    assert faults == {}
