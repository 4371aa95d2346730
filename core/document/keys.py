"""Key frames of one parameter, and its value between them."""

import math
from bisect import bisect_right
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, TypeAlias, get_args

from core.arrays import InputError

Easing: TypeAlias = Literal["linear", "hold", "ease", "ease-in", "ease-out"]
EASINGS: tuple[Easing, ...] = get_args(Easing)
MOST_FRAMES = 10_000_000
"""A timeline begins and ends at most so many frames from 0."""

_SHARES: Mapping[Easing, Callable[[float], float]] = {
    "linear": lambda t: t,
    "hold": lambda _: 0.0,
    "ease": lambda t: t * t * (3 - 2 * t),
    "ease-in": lambda t: t * t,
    "ease-out": lambda t: t * (2 - t),
}
"""Which share of the way between two keys is gone after the share t of the time, both from 0 to 1."""


@dataclass(frozen=True)
class KeyFrame:
    """The value of a parameter at one frame."""

    frame: float
    value: tuple[float, ...]
    """One number, or the two of a place or a size."""
    easing: Easing = "linear"
    """How the way to the next key is gone: evenly, not before the end, or gently at both ends, the first, the last."""


Track: TypeAlias = tuple[KeyFrame, ...]
"""The keys of one parameter, in the order of their frames."""


@dataclass(frozen=True)
class Span:
    """Which frames a timeline has, and how fast they follow one another.

    Raises `InputError` for frames out of order, and for a rate that is not above 0 and up to 1000.
    """

    first: int = 1
    last: int = 100
    rate: float = 24.0
    """Frames a second."""

    def __post_init__(self) -> None:
        if not -MOST_FRAMES <= self.first <= self.last <= MOST_FRAMES:
            raise InputError(f"timeline: frames {self.first} to {self.last} are out of order, or too many")
        if not 0 < self.rate <= 1000:
            raise InputError(f"timeline: {self.rate:g} frames a second are not above 0 and up to 1000")


def value_at(track: Track, frame: float) -> tuple[float, ...]:
    """Return the value at `frame`; before the first key it is the first one's, behind the last the last one's."""
    after = bisect_right([key.frame for key in track], frame)
    if after == 0:
        return track[0].value
    if after == len(track):
        return track[-1].value
    a, b = track[after - 1], track[after]
    share = _SHARES[a.easing]((frame - a.frame) / (b.frame - a.frame))
    return tuple(x + share * (y - x) for x, y in zip(a.value, b.value, strict=True))


def check_track(track: Track, numbers: int, name: str) -> None:
    """Raise `InputError` that says `name` unless the keys of `track` are in order and hold so many finite numbers."""
    for key in track:
        if len(key.value) != numbers:
            raise InputError(f"keys of {name}: frame {key.frame:g} has {len(key.value)} numbers, not {numbers}")
        if not all(map(math.isfinite, (key.frame, *key.value))):
            raise InputError(f"keys of {name}: frame {key.frame:g} has a value that is not a finite number")
    for a, b in pairwise(track):
        if not a.frame < b.frame:
            raise InputError(f"keys of {name}: frame {b.frame:g} comes after frame {a.frame:g}")


def with_key(track: Track, frame: float, value: tuple[float, ...]) -> Track:
    """Return the track with a value at `frame`; a new key is eased as the way that it lies on, the first one gently."""
    before = [key for key in track if key.frame <= frame]
    easing = before[-1].easing if before else track[0].easing if track else "ease"
    return tuple(sorted((*without_keys(track, (frame,)), KeyFrame(frame, value, easing)), key=lambda key: key.frame))


def without_keys(track: Track, frames: Collection[float]) -> Track:
    """Return the track without the keys at some frames."""
    return tuple(key for key in track if key.frame not in frames)


def with_moved_keys(track: Track, frames: Collection[float], by: float) -> Track:
    """Return the track with the keys at some frames moved `by` so many; they replace what they come to lie on."""
    moved = [replace(key, frame=key.frame + by) for key in track if key.frame in frames]
    stay = without_keys(without_keys(track, frames), [key.frame for key in moved])
    return tuple(sorted((*stay, *moved), key=lambda key: key.frame))


def with_easing(track: Track, frames: Collection[float], easing: Easing) -> Track:
    """Return the track with another way from the keys at some frames to those after them."""
    return tuple(replace(key, easing=easing) if key.frame in frames else key for key in track)
