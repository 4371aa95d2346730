"""Two folders that change places at once: one or the other is at each name, at every moment.

Linux has a call for it (renameat2 with RENAME_EXCHANGE), which Python does not offer.
"""

import ctypes
import os
import sys
from pathlib import Path

_AT_FDCWD, _RENAME_EXCHANGE = -100, 2


def exchange(a: Path, b: Path) -> bool:
    """Let `a` and `b` change places; return whether the system and the file system can do it, else nothing is done."""
    if not sys.platform.startswith("linux"):
        return False
    try:
        call = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return False
    return bool(call(_AT_FDCWD, os.fsencode(a), _AT_FDCWD, os.fsencode(b), _RENAME_EXCHANGE) == 0)
