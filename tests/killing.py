"""Makes a process kill itself while it moves files into place."""

import os
import signal
from pathlib import Path


def kill_before_move(number: int) -> None:
    """Let so many files be moved by this process, and no more."""
    left, replace = [number], Path.replace

    def move_or_die(self: Path, target: str | os.PathLike[str]) -> Path:
        if left[0] == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        left[0] -= 1
        return replace(self, target)

    Path.replace = move_or_die  # type: ignore[assignment, method-assign]
