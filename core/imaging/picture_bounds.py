"""How large a picture may be that is read: what the program draws, and what the machine can hold."""

import contextlib
import os
from pathlib import Path

from core.arrays import InputError
from core.canvas import MOST_PIXELS, MOST_SIDE_PX

COPIES = 2
"""A picture is in memory so often while it is read."""
_GROUP_LIMIT = Path("/sys/fs/cgroup/memory.max")


class TooLargeError(InputError):
    """A picture that cannot be held."""


def memory_bytes() -> int | None:
    """Return how much memory the program can have at most; None where the system does not say."""
    try:
        limits = [os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")]
    except (AttributeError, OSError, ValueError):
        return None
    with contextlib.suppress(OSError, ValueError):  # no group, or one without a limit
        limits.append(int(_GROUP_LIMIT.read_text()))
    return min(limits)


def check_size(size_px: tuple[int, int], pixel_bytes: int, name: object) -> None:
    """Raise `TooLargeError`, which gives `name`, for a picture of a width and height that cannot be held."""
    width, height = size_px
    if max(width, height) > MOST_SIDE_PX or width * height > MOST_PIXELS:
        raise TooLargeError(
            f"{name}: {width}x{height} pixels: a picture may have {MOST_SIDE_PX} a side, {MOST_PIXELS} in all"
        )
    need, most = COPIES * width * height * pixel_bytes, memory_bytes()
    if most is not None and need > most:
        raise TooLargeError(
            f"{name}: {width}x{height} pixels take {need / 1e9:.1f} GB, the machine has {most / 1e9:.1f} GB"
        )
