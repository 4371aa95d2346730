"""Frame numbers, and names of files that hold one: `shot.####.exr`, `shot.%04d.exr`."""

import re
from collections.abc import Iterator
from pathlib import Path

from core.arrays import InputError

_PLACE = re.compile(r"#+|%0?\d*d")
_RANGE = re.compile(r"(-?\d{1,9})(?:-(-?\d{1,9})(?:x([1-9]\d{0,8}))?)?")
MOST_FRAMES = 10_000_000


def is_numbered(name: str) -> bool:
    """Return whether a name has a place for the number of a frame."""
    return _PLACE.search(name) is not None


def numbered(name: str, frame: int) -> str:
    """Return `name` with the number of a frame in its places, with zeros in front as the place says."""
    return _PLACE.sub(lambda place: _digits(place[0], frame), name)


def _digits(place: str, frame: int) -> str:
    return f"{frame:0{len(place)}d}" if place[0] == "#" else place % frame


def unnumbered(name: str) -> str:
    """Return `name` without the places for numbers."""
    return _PLACE.sub("", name)


def parse_frames(text: str) -> tuple[int, ...]:
    """Return the frames of a text like `1-500`, `1-100x10` (every tenth) or `1-3,7`, in order, each once.

    Raises `InputError` for what is none.
    """
    found: set[int] = set()
    for part in text.split(","):
        match = _RANGE.fullmatch(part.strip())
        if match is None:
            raise InputError(f"frames {text!r}: not like 1-500, 1-100x10 or 1-3,7")
        first, last, step = int(match[1]), int(match[2] or match[1]), int(match[3] or 1)
        if last < first:
            raise InputError(f"frames {text!r}: {part.strip()} ends before it begins")
        if (last - first) // step >= MOST_FRAMES:
            raise InputError(f"frames {text!r}: more than {MOST_FRAMES} frames")
        found.update(range(first, last + 1, step))
    return tuple(sorted(found))


def frames_on_disk(pattern: Path) -> tuple[int, ...]:
    """Return the numbers of the files that there are of a numbered name."""
    return tuple(sorted(set(_find(pattern))))


def _find(pattern: Path) -> Iterator[int]:
    first = _PLACE.search(pattern.name)
    assert first is not None
    fixed = [re.escape(part) for part in (pattern.name[: first.start()], _PLACE.sub("", pattern.name[first.end() :]))]
    wanted = re.compile(rf"{fixed[0]}(-?\d+){fixed[1]}")
    for file in pattern.parent.iterdir() if pattern.parent.is_dir() else ():
        match = wanted.fullmatch(file.name)
        if match is not None and numbered(pattern.name, int(match[1])) == file.name:
            yield int(match[1])
