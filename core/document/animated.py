"""A document with key frames: what has keys, the values at a frame, and the keys that a changed value makes."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TypeAlias

from core.arrays import InputError
from core.document.document import Document, Place
from core.document.keys import Track, check_track, value_at, with_key
from core.warps.presets import PRESETS

Animated: TypeAlias = str | int
"""What can have keys: a parameter of the warp by its name, or a pin by its number from 0 on."""
NUMBERS = {"bend": 1, "horizontal": 1, "vertical": 1, "size": 2}
"""The tracks of every warp, and how many numbers their keys have; others set a parameter of the preset's own."""
_LEAST_ASPECT, _MOST_ASPECT = 1e-4, 1e4


def tracks_of(document: Document) -> dict[Animated, Track]:
    """Return the tracks that have keys: those of parameters, then those of pins."""
    parameters = {name: track for name, track in document.tracks.items() if track}
    return parameters | {number: pin.keys for number, pin in enumerate(document.pins) if pin.keys}


def is_animated(document: Document) -> bool:
    """Return whether the document changes from frame to frame."""
    return bool(tracks_of(document))


def key_frames(document: Document) -> tuple[float, ...]:
    """Return the frames at which anything has a key, in order."""
    return tuple(sorted({key.frame for track in tracks_of(document).values() for key in track}))


def value_of(document: Document, what: Animated) -> tuple[float, ...]:
    """Return the present value: one number, or the two of a place or of a size in times the picture's."""
    if isinstance(what, int):
        return document.pins[what].to
    if what == "size":
        return document.warp.aspect
    if what in NUMBERS:
        return (float(getattr(document.warp, what)),)
    defaults = {setting.name: setting.default for setting in PRESETS[document.warp.preset or "none"].settings}
    return (float(document.warp.values.get(what, defaults.get(what, 0.0))),)


def with_track(document: Document, what: Animated, track: Track) -> Document:
    """Return the document with other keys of a parameter or of a pin; no keys let its value stand still."""
    if isinstance(what, int):
        pins = list(document.pins)
        pins[what] = replace(pins[what], keys=track)
        return document.changed(pins=tuple(pins))
    tracks = {**document.tracks, what: track}
    return document.changed(tracks=MappingProxyType({name: keys for name, keys in tracks.items() if keys}))


def pose(document: Document, frame: float) -> Document:
    """Return the document with the values that it has at `frame`, and its keys; itself where it has those values."""
    return _with_values(document, {what: value_at(track, frame) for what, track in tracks_of(document).items()})


def set_keys(document: Document, frame: float) -> Document:
    """Return the document with a key at `frame` wherever a value is another than its keys say."""
    for what, track in tracks_of(document).items():
        value = value_of(document, what)
        if value != value_at(track, frame):
            document = with_track(document, what, with_key(track, frame, value))
    return document


def document_at(document: Document, frame: float) -> Document:
    """Return the document as it is at `frame`, without keys; itself where it has none.

    Raises `InputError` that names the parameter whose keys cannot be.
    """
    if not is_animated(document):
        return document
    check_tracks(document)
    found = pose(document, frame)
    pins = tuple(replace(pin, keys=()) if pin.keys else pin for pin in found.pins)
    return found.changed(pins=pins, tracks=MappingProxyType({}))


def check_tracks(document: Document) -> None:
    """Raise `InputError` that names the first parameter, or pin from 1 on, whose keys cannot be."""
    for what, track in tracks_of(document).items():
        name = f"pin {what + 1}" if isinstance(what, int) else what
        check_track(track, 2 if isinstance(what, int) else NUMBERS.get(what, 1), name)
        for key in track if what == "size" else ():
            if not all(_LEAST_ASPECT <= factor <= _MOST_ASPECT for factor in key.value):
                width, height = key.value
                raise InputError(f"keys of size: {width:g} x {height:g} times the picture's size is out of all bounds")


def _with_values(document: Document, values: Mapping[Animated, tuple[float, ...]]) -> Document:
    """Return the document with other values of parameters and pins; itself where they are the same."""
    changes: dict[str, object] = {}
    own, pins = dict(document.warp.values), list(document.pins)
    for what, value in values.items():
        if isinstance(what, int):
            pins[what] = replace(pins[what], to=_pair(value))
        elif what == "size":
            changes["aspect"] = _pair(value)
        elif what in NUMBERS:
            changes[what] = value[0]
        else:
            own[what] = value[0]
    found = document.with_warp(values=MappingProxyType(own), **changes)
    return found if tuple(pins) == document.pins else found.changed(pins=tuple(pins))


def _pair(value: tuple[float, ...]) -> Place:
    x, y = value
    return x, y
