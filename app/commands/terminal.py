"""Progress on standard error, where that is a terminal."""

import sys
from collections.abc import Callable

from core.progress import Progress


def on_terminal() -> Callable[[Progress], None] | None:
    """Return what shows a job's steps in one line of standard error, or None where nobody looks."""
    return show if sys.stderr.isatty() else None


def show(step: Progress) -> None:
    """Overwrite the line with the step; the last one clears it."""
    text = "" if step.fraction >= 1 else f"{step.fraction:4.0%} {step.note}"
    sys.stderr.write(f"\r\x1b[K{text}")
    sys.stderr.flush()
