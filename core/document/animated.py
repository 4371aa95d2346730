"""A document with key frames, as it is at one of its frames."""

from dataclasses import replace
from types import MappingProxyType

from core.arrays import InputError
from core.document.document import Document, Pin, Place
from core.document.keys import check_track, value_at

NUMBERS = {"bend": 1, "horizontal": 1, "vertical": 1, "size": 2}
"""The tracks of every warp, and how many numbers their keys have; others set a parameter of the preset's own."""
_LEAST_ASPECT, _MOST_ASPECT = 1e-4, 1e4


def is_animated(document: Document) -> bool:
    """Return whether the document changes from frame to frame."""
    return any(document.tracks.values()) or any(pin.keys for pin in document.pins)


def key_frames(document: Document) -> tuple[float, ...]:
    """Return the frames at which any parameter has a key, in order."""
    tracks = [*document.tracks.values(), *(pin.keys for pin in document.pins)]
    return tuple(sorted({key.frame for track in tracks for key in track}))


def document_at(document: Document, frame: float) -> Document:
    """Return the document as it is at `frame`, without keys; itself where it has none.

    Raises `InputError` that names the parameter whose keys cannot be.
    """
    if not is_animated(document):
        return document
    pins = tuple(_pin_at(pin, number, frame) for number, pin in enumerate(document.pins, 1))
    return _with_values(document, frame).changed(pins=pins, tracks=MappingProxyType({}))


def _with_values(document: Document, frame: float) -> Document:
    """Return the document with the parameters of its warp as they are at `frame`."""
    changes: dict[str, object] = {}
    own = dict(document.warp.values)
    for name, track in document.tracks.items():
        if not track:
            continue
        check_track(track, NUMBERS.get(name, 1), name)
        value = value_at(track, frame)
        if name == "size":
            changes["aspect"] = _aspect(value)
        elif name in NUMBERS:
            changes[name] = value[0]
        else:
            own[name] = value[0]
    return document.with_warp(values=MappingProxyType(own), **changes)


def _aspect(value: tuple[float, ...]) -> Place:
    width, height = value
    if not all(_LEAST_ASPECT <= factor <= _MOST_ASPECT for factor in value):
        raise InputError(f"keys of size: {width:g} x {height:g} times the picture's size is out of all bounds")
    return width, height


def _pin_at(pin: Pin, number: int, frame: float) -> Pin:
    if not pin.keys:
        return pin
    check_track(pin.keys, 2, f"pin {number}")
    x, y = value_at(pin.keys, frame)
    return replace(pin, to=(x, y), keys=())
