"""Metadata on its way into files: what a file cannot hold is left out, for it must never stop a picture's save.

Cameras and programs write text in whatever encoding they like, and numbers that are none. OpenImageIO refuses some of
it with an exception, some in silence, and some only when the file is closed.
"""

from collections.abc import Callable, Iterable
from typing import Any

import OpenImageIO

from core.files.text import legible
from core.imaging.image import Attribute

_SHORT = {"uint8", "uint16", "int16", "uint"}


def as_text(value: Any) -> Any:
    """Return a legible text for a text, all else as it is."""
    return legible(value) if isinstance(value, str) else value


def put(spec: OpenImageIO.ImageSpec, attribute: Attribute) -> bool:
    """Add `attribute` to the description of a file; return whether OpenImageIO took it."""
    name, kind, value = attribute
    try:
        # Short integers are left out of EXIF by OpenImageIO, plain ones are not.
        spec.attribute(as_text(name), OpenImageIO.TypeDesc("int" if kind in _SHORT else kind), as_text(value))
        return spec.getattribute(as_text(name)) is not None
    except (TypeError, ValueError, RuntimeError, OverflowError):
        return False


def sift(
    metadata: Iterable[Attribute], fits: Callable[[tuple[Attribute, ...]], bool]
) -> tuple[tuple[Attribute, ...], tuple[Attribute, ...]]:
    """Return the entries that go together into what `fits` tries, and those that do not; both in their order.

    Where `fits` refuses some entries they are halved until the bad ones stand alone: for b bad ones of n, that is about
    b log n trials.
    """
    kept: list[Attribute] = []
    dropped: list[Attribute] = []

    def add(entries: tuple[Attribute, ...]) -> None:
        if fits((*kept, *entries)):
            kept.extend(entries)
        elif len(entries) == 1:
            dropped.extend(entries)
        else:
            middle = len(entries) // 2
            add(entries[:middle])
            add(entries[middle:])

    entries = tuple(metadata)
    if entries:
        add(entries)
    return tuple(kept), tuple(dropped)
