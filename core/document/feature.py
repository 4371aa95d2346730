"""What the artist said of a single feature."""

from dataclasses import dataclass
from math import inf
from typing import Any, Literal, get_args

from core.arrays import InputError
from core.mapping.features.limits import Limits

KeptAs = Literal["similarity", "rigid", "lines"]
"""By a similarity, by one that leaves its size, or bent with the warp but for its long straight lines."""


@dataclass(frozen=True)
class Feature:
    """What the artist said of a feature that has a number; of others nothing is said.

    Raises `InputError` for sizes that nothing lies between, and for a weight beyond 0 to 1.
    """

    number: int
    """That of its pixels in `Document.numbers`, 1 to 255."""
    name: str = ""
    """Empty for one that goes by its number."""
    kept: bool = True
    """Whether it keeps its shape; else it is warped like what is not painted."""
    keep: KeptAs | None = None
    """How it keeps it; None for as all do: `WarpSettings.keep`."""
    upright: bool = False
    """Whether it does not turn."""
    least: float | None = None
    most: float | None = None
    """Its size at least and at most, in times that in the picture; None for no bound. A rigid one has its own."""
    weight: float = 1.0
    """How much it is protected, 0 to 1: under 1 softly, with 0 not at all."""

    def __post_init__(self) -> None:
        self.limits(rigid=False)
        if not 0 <= self.weight <= 1:
            raise InputError(f"protection of a feature by {self.weight:g}: must be from 0 to 1")

    @property
    def is_kept(self) -> bool:
        """Whether anything of its shape is kept."""
        return self.kept and self.weight > 0

    @property
    def keeps_lines(self) -> bool:
        """Whether its long straight lines are all that is kept."""
        return self.is_kept and self.keep == "lines"

    def limits(self, *, rigid: bool) -> Limits:
        """Return what it may do where those of which nothing is said are `rigid`, or similar."""
        weight = self.weight or 1.0
        if rigid if self.keep is None else self.keep == "rigid":
            return Limits(1.0, 1.0, not self.upright, weight)
        return Limits(self.least or 0.0, inf if self.most is None else self.most, not self.upright, weight)


def read_feature(number: str, how: str) -> Feature:
    """Return what the words `how`, with commas between them, say of a feature; raise `InputError` for other words."""
    said: dict[str, Any] = {}
    for word in how.split(","):
        name, _, value = word.partition(":")
        if word in get_args(KeptAs):
            said["keep"] = word
        elif word in ("none", "upright"):
            said |= {"kept": False} if word == "none" else {"upright": True}
        elif name in ("least", "most", "weight"):
            said[name] = _number(value)
        else:
            raise InputError(f"{word!r} is no way to keep a feature")
    if not (number.isascii() and number.isdigit()):
        raise InputError(f"{number!r} is no number of a feature")
    return Feature(int(number), **said)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{text!r} is no number") from None
