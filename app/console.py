"""What a command says while it works."""

import sys
from typing import TypeVar

from core.progress import Job, Progress, run

T = TypeVar("T")


def run_shown(job: Job[T]) -> T:
    """Run `job` to its end, its progress on standard error if that is a terminal, and return its result."""
    if not sys.stderr.isatty():
        return run(job)
    try:
        return run(job, _show)
    finally:
        sys.stderr.write("\r\x1b[K")
        sys.stderr.flush()


def _show(step: Progress) -> None:
    """Overwrite the line with how far the job is."""
    sys.stderr.write(f"\r\x1b[K{step.fraction:4.0%} {step.note}"[:100])
    sys.stderr.flush()
