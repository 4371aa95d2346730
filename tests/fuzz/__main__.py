"""Try malformed files until the time is up: `python -m tests.fuzz [--seconds S] [--seed N] [READER ...]`.

Every file follows from the name of its reader and a number, so that a fault can be seen again: `--only READER:NUMBER`.
"""

import argparse
import sys
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path

from tests.fuzz.readers import READERS, answers, scratch

AT_ONCE = 50
"""So many files are made in one folder."""


def main() -> int:
    """Run the fuzzer; return 1 where a fault was found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("readers", nargs="*", choices=[*READERS, []], help="which readers; all by default")
    parser.add_argument("--seconds", type=float, default=120.0)
    parser.add_argument("--seed", type=int, default=0, help="number of the first file")
    parser.add_argument("--only", metavar="READER:NUMBER", help="one file, with its traceback")
    arguments = parser.parse_args()
    warnings.simplefilter("error")
    if arguments.only:
        name, _, seed = arguments.only.partition(":")
        with scratch() as folder:
            print(answers(READERS[name], int(seed), Path(folder)))  # noqa: T201
        return 0
    return _run(arguments.readers or list(READERS), arguments.seconds, arguments.seed)


def _run(names: list[str], seconds: float, first: int) -> int:
    tried: Counter[str] = Counter()
    taken: Counter[str] = Counter()
    faults: dict[str, str] = {}
    for name in names:
        ends = time.monotonic() + seconds / len(names)
        begin = first
        while time.monotonic() < ends:
            with scratch() as folder:
                for seed in range(begin, begin + AT_ONCE):
                    tried[name] += 1
                    try:
                        taken[name] += answers(READERS[name], seed, Path(folder))
                    except Exception as fault:  # noqa: BLE001  each is what is looked for
                        place = traceback.extract_tb(fault.__traceback__)[-1]
                        key = f"{name} {type(fault).__name__} {place.filename}:{place.lineno}"
                        faults.setdefault(key, f"{name}:{seed}  {key}  {str(fault)[:100]}")
            begin += AT_ONCE
        sys.stdout.write(f"{name:12s} {tried[name]:9d} tried  {taken[name]:9d} taken\n")
        sys.stdout.flush()
    for line in faults.values():
        sys.stdout.write(f"FAULT {line}\n")
    sys.stdout.write(f"{sum(tried.values())} files, {len(faults)} different faults\n")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
