"""Every malformed file that was ever answered wrongly is answered rightly, and so are some new ones of each kind."""

import json
from pathlib import Path

import pytest

from tests.fuzz.readers import READERS, answers

KEPT = json.loads(Path(__file__).with_name("kept.json").read_text())
FRESH = 40
"""So many more files of each kind."""


@pytest.mark.parametrize(("name", "seed"), [(name, seed) for name, seeds in KEPT.items() for seed in seeds])
def test_a_file_that_was_answered_wrongly_is_answered_rightly(name: str, seed: int, tmp_path: Path) -> None:
    answers(READERS[name], seed, tmp_path)


@pytest.mark.parametrize("name", READERS)
def test_malformed_files_are_read_or_refused_in_one_line(name: str, tmp_path: Path) -> None:
    for seed in range(FRESH):
        answers(READERS[name], seed, tmp_path)
