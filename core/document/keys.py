"""Key frames of one parameter, and its value between them."""

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias, get_args

from core.arrays import InputError

Easing: TypeAlias = Literal["linear", "hold", "ease", "ease-in", "ease-out"]
EASINGS: tuple[Easing, ...] = get_args(Easing)

_SHARES: Mapping[Easing, Callable[[float], float]] = {
    "linear": lambda t: t,
    "hold": lambda _: 0.0,
    "ease": lambda t: t * t * (3 - 2 * t),
    "ease-in": lambda t: t * t,
    "ease-out": lambda t: t * (2 - t),
}
"""Which share of the way between two keys is gone after the share t of the time, both from 0 to 1."""


@dataclass(frozen=True)
class Key:
    """The value of a parameter at one frame."""

    frame: float
    value: tuple[float, ...]
    """One number, or the two of a place or a size."""
    easing: Easing = "linear"
    """How the way to the next key is gone: evenly, not before the end, or gently at both ends, the first, the last."""


Track: TypeAlias = tuple[Key, ...]
"""The keys of one parameter, in the order of their frames."""


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
